#pragma once
/// The number types of the kernels: `double`, `Lanes` = eight doubles computed at once, and `LanePair` = two Lanes.
///
/// `Lanes` is a GCC/Clang vector extension: + - * / and comparisons work on it as on a scalar, and the compiler maps it
/// to one AVX-512, two AVX or four SSE2 registers. The functions below exist for both types, so that a template over the
/// number type reads the same for one material point and for eight; branches become `select`.

#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>

#include "libmpm/base/types.hpp"

#if defined(__AVX512F__) || defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif

namespace mpm {

using Lanes = double __attribute__((vector_size(64)));           ///< eight doubles
using LaneMask = std::int64_t __attribute__((vector_size(64)));  ///< all bits set where true
using HalfLanes = double __attribute__((vector_size(32)));       ///< four lanes: a grid node {p_x, p_y, p_z, m}

/// {a, b}: lanes 0 to 3 from a, 4 to 7 from b.
inline Lanes join(HalfLanes a, HalfLanes b) { return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7); }
/// Lanes 0 to 3.
inline HalfLanes lower_half(Lanes v) { return __builtin_shufflevector(v, v, 0, 1, 2, 3); }
/// Lanes 4 to 7.
inline HalfLanes upper_half(Lanes v) { return __builtin_shufflevector(v, v, 4, 5, 6, 7); }

/// Sixteen doubles: two Lanes side by side. A law is one long chain of operations that wait for each other; two independent groups in
/// one stream of instructions hide each other's latency (measured: the yielding law takes a quarter less time, benchmarks/README.md).
struct LanePair {
  Lanes a, b;  ///< lanes 0 to 7 and 8 to 15
};
/// What a comparison of LanePairs gives.
struct LanePairMask {
  LaneMask a, b;  ///< of lanes 0 to 7 and 8 to 15
};

/// The number types that a law and a tensor can be computed with.
template <class T>
concept LaneNumber = std::same_as<T, double> || std::same_as<T, Lanes> || std::same_as<T, LanePair>;

/// Lane by lane; a scalar operand counts for every lane.
/// @{
inline LanePair operator+(const LanePair& x, const LanePair& y) { return {x.a + y.a, x.b + y.b}; }
inline LanePair operator-(const LanePair& x, const LanePair& y) { return {x.a - y.a, x.b - y.b}; }
inline LanePair operator*(const LanePair& x, const LanePair& y) { return {x.a * y.a, x.b * y.b}; }
inline LanePair operator/(const LanePair& x, const LanePair& y) { return {x.a / y.a, x.b / y.b}; }
inline LanePair operator+(const LanePair& x, double y) { return {x.a + y, x.b + y}; }
inline LanePair operator-(const LanePair& x, double y) { return {x.a - y, x.b - y}; }
inline LanePair operator*(const LanePair& x, double y) { return {x.a * y, x.b * y}; }
inline LanePair operator+(double x, const LanePair& y) { return {x + y.a, x + y.b}; }
inline LanePair operator-(double x, const LanePair& y) { return {x - y.a, x - y.b}; }
inline LanePair operator*(double x, const LanePair& y) { return {x * y.a, x * y.b}; }
inline LanePair operator/(double x, const LanePair& y) { return {x / y.a, x / y.b}; }
inline LanePair operator-(const LanePair& x) { return {-x.a, -x.b}; }
inline LanePair& operator+=(LanePair& x, const LanePair& y) { return x = x + y; }
inline LanePair& operator*=(LanePair& x, const LanePair& y) { return x = x * y; }
inline LanePairMask operator<(const LanePair& x, const LanePair& y) { return {x.a < y.a, x.b < y.b}; }
inline LanePairMask operator<=(const LanePair& x, const LanePair& y) { return {x.a <= y.a, x.b <= y.b}; }
inline LanePairMask operator>(const LanePair& x, const LanePair& y) { return {x.a > y.a, x.b > y.b}; }
inline LanePairMask operator<(const LanePair& x, double y) { return {x.a < y, x.b < y}; }
inline LanePairMask operator<=(const LanePair& x, double y) { return {x.a <= y, x.b <= y}; }
inline LanePairMask operator>(const LanePair& x, double y) { return {x.a > y, x.b > y}; }
inline LanePairMask operator>=(const LanePair& x, double y) { return {x.a >= y, x.b >= y}; }
inline LanePairMask operator&(const LanePairMask& x, const LanePairMask& y) { return {x.a & y.a, x.b & y.b}; }
inline LanePairMask operator|(const LanePairMask& x, const LanePairMask& y) { return {x.a | y.a, x.b | y.b}; }
/// @}

namespace detail {
template <class T>
struct MaskOf {
  using type = bool;
};
template <>
struct MaskOf<Lanes> {
  using type = LaneMask;
};
template <>
struct MaskOf<LanePair> {
  using type = LanePairMask;
};
}  // namespace detail
/// What a comparison of two T gives: bool, LaneMask or LanePairMask.
template <class T>
using Mask = typename detail::MaskOf<T>::type;

/// The same value in every lane.
template <LaneNumber T>
inline T broadcast(double a) {
  if constexpr (std::same_as<T, LanePair>) {
    return {Lanes{} + a, Lanes{} + a};
  } else {
    return T{} + a;
  }
}

/// a where m is true, else b; lane by lane. Both are evaluated.
/// @{
inline double select(bool m, double a, double b) { return m ? a : b; }
inline Lanes select(LaneMask m, Lanes a, Lanes b) { return m ? a : b; }
/// @}

/// Whether m is true in some lane.
inline bool any(bool m) { return m; }
/// Whether m is true in every lane.
inline bool all(bool m) { return m; }
/// Whether m is true in some lane.
inline bool any(LaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) != 0;
#else
  std::int64_t r = 0;
  for (int i = 0; i < lane_count; ++i) r |= m[i];
  return r != 0;
#endif
}
/// Whether m is true in every lane.
inline bool all(LaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) == 0xFF;
#else
  std::int64_t r = -1;
  for (int i = 0; i < lane_count; ++i) r &= m[i];
  return r != 0;
#endif
}
/// The opposite, lane by lane.
/// @{
inline bool mask_not(bool m) { return !m; }
inline LaneMask mask_not(LaneMask m) { return ~m; }
/// @}

/// Lane by lane. Where an operand of max or min is NaN, the result is b.
/// @{
inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
inline Lanes max(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes min(Lanes a, Lanes b) { return a < b ? a : b; }
inline double abs(double a) { return std::fabs(a); }
inline Lanes abs(Lanes a) { return std::bit_cast<Lanes>(std::bit_cast<LaneMask>(a) & std::int64_t{0x7FFFFFFFFFFFFFFF}); }
/// @}

/// Square root, lane by lane; NaN for a negative number.
/// @{
inline double sqrt(double a) { return std::sqrt(a); }
inline Lanes sqrt(Lanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<Lanes>(_mm512_maskz_sqrt_pd(0xFF, reinterpret_cast<__m512d>(a)));
#else
  Lanes r;
  for (int i = 0; i < lane_count; ++i) r[i] = std::sqrt(a[i]);
  return r;
#endif
}
/// @}

/// Eight integers as signed bytes, lane 0 lowest; what does not fit becomes the nearest that does.
inline std::uint64_t saturated_bytes(LaneMask a) {
#if defined(__AVX512F__)
  return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm512_maskz_cvtsepi64_epi8(0xFF, reinterpret_cast<__m512i>(a))));
#else
  std::uint64_t bytes = 0;
  for (int i = 0; i < lane_count; ++i) {
    const std::int64_t low = a[i] < -128 ? -128 : a[i], fits = low > 127 ? 127 : low;
    bytes |= (static_cast<std::uint64_t>(fits) & 0xFFU) << (8 * i);
  }
  return bytes;
#endif
}

namespace detail {
// glibc's vector mathematics (libmvec, at most 4 ulp), called by its published x86 vector-ABI names: no -ffast-math needed.
#if defined(__AVX512F__)
extern "C" __m512d _ZGVeN8v_exp(__m512d);
extern "C" __m512d _ZGVeN8v_log(__m512d);
inline Lanes mvec_exp(const Lanes& x) { return reinterpret_cast<Lanes>(_ZGVeN8v_exp(reinterpret_cast<__m512d>(x))); }
inline Lanes mvec_log(const Lanes& x) { return reinterpret_cast<Lanes>(_ZGVeN8v_log(reinterpret_cast<__m512d>(x))); }
#else
#if defined(__AVX2__)
using MvecPart = __m256d;
extern "C" __m256d _ZGVdN4v_exp(__m256d);
extern "C" __m256d _ZGVdN4v_log(__m256d);
inline MvecPart mvec_exp(MvecPart x) { return _ZGVdN4v_exp(x); }
inline MvecPart mvec_log(MvecPart x) { return _ZGVdN4v_log(x); }
#else
using MvecPart = __m128d;
extern "C" __m128d _ZGVbN2v_exp(__m128d);
extern "C" __m128d _ZGVbN2v_log(__m128d);
inline MvecPart mvec_exp(MvecPart x) { return _ZGVbN2v_exp(x); }
inline MvecPart mvec_log(MvecPart x) { return _ZGVbN2v_log(x); }
#endif
template <class F>
inline Lanes in_parts(const Lanes& x, F f) {
  MvecPart part[sizeof(Lanes) / sizeof(MvecPart)];
  std::memcpy(part, &x, sizeof x);
  for (MvecPart& p : part) p = f(p);
  Lanes r;
  std::memcpy(&r, part, sizeof r);
  return r;
}
inline Lanes mvec_exp(const Lanes& x) {
  return in_parts(x, [](MvecPart p) { return mvec_exp(p); });
}
inline Lanes mvec_log(const Lanes& x) {
  return in_parts(x, [](MvecPart p) { return mvec_log(p); });
}
#endif
}  // namespace detail

namespace detail {
/// 1/n!, by table: constants that the compiler folds into the unrolled series.
inline constexpr auto inverse_factorials = [] {
  std::array<double, 18> table{1.0};
  for (std::size_t n = 1; n < table.size(); ++n) table[n] = table[n - 1] / static_cast<double>(n);
  return table;
}();
constexpr double inverse_factorial(int n) { return inverse_factorials[static_cast<std::size_t>(n)]; }
}  // namespace detail

/// exp, log, and the three that keep relative precision however small the argument: expm1(x) = e^x - 1, log1p(x) = log(1 + x), sinh(x).
/// In lanes a truncated power series (truncation below 1e-16 of the value inside the stated radius) serves small arguments;
/// libmvec is called only if some lane is outside the radius.
/// @{
inline double exp(double x) { return std::exp(x); }
inline double log(double x) { return std::log(x); }
inline double expm1(double x) { return std::expm1(x); }
inline double log1p(double x) { return std::log1p(x); }
inline double sinh(double x) { return std::sinh(x); }
inline Lanes exp(const Lanes& x) { return detail::mvec_exp(x); }
inline Lanes log(const Lanes& x) { return detail::mvec_log(x); }
/// @}
namespace detail {
/// sum_{k=0}^{terms-1} f(k) x^k by Horner, unrolled.
template <int terms, class Coefficient>
inline Lanes horner(const Lanes& x, Coefficient f) {
  Lanes sum = broadcast<Lanes>(f(terms - 1));
#pragma GCC unroll 16
  for (int k = terms - 2; k >= 0; --k) sum = f(k) + sum * x;
  return sum;
}
}  // namespace detail
/// e^x - 1, to relative precision.
inline Lanes expm1(const Lanes& x) {
  constexpr auto coefficient = [](int k) { return detail::inverse_factorial(k + 1); };
  const Lanes magnitude = abs(x);
  if (all(magnitude <= 0.05)) return x * detail::horner<9>(x, coefficient);  // 0.05^9 / 10! = 5e-19
  const Lanes series = x * detail::horner<13>(x, coefficient);               // 0.35^13 / 14! = 1.4e-17
  const LaneMask small = magnitude <= 0.35;
  if (all(small)) return series;
  return select(small, series, detail::mvec_exp(x) - 1.0);
}
/// log(1 + x), to relative precision.
inline Lanes log1p(const Lanes& x) {
  constexpr auto coefficient = [](int k) { return 2.0 / (2 * k + 1); };  // 2 artanh(z) = 2 (z + z^3/3 + z^5/5 + ...)
  const Lanes z = x / (2.0 + x), z2 = z * z, magnitude = abs(x);
  if (all(magnitude <= 0.05)) return z * detail::horner<6>(z2, coefficient);  // |z| <= 0.0257: 0.0257^12 / 13 = 6e-21
  const Lanes series = z * detail::horner<12>(z2, coefficient);               // |z| <= 0.213: 0.213^24 / 25 = 3e-18
  const LaneMask small = magnitude <= 0.35;
  if (all(small)) return series;
  return select(small, series, detail::mvec_log(1.0 + x));
}
/// To relative precision.
inline Lanes sinh(const Lanes& x) {
  constexpr auto coefficient = [](int k) { return detail::inverse_factorial(2 * k + 1); };
  const Lanes x2 = x * x, magnitude = abs(x);
  if (all(magnitude <= 0.1)) return x * detail::horner<5>(x2, coefficient);  // 0.1^10 / 11! = 3e-18
  const Lanes series = x * detail::horner<8>(x2, coefficient);               // 0.5^16 / 17! = 4e-20
  const LaneMask small = magnitude <= 0.5;
  if (all(small)) return series;
  const Lanes e = detail::mvec_exp(magnitude), large = 0.5 * (e - 1.0 / e);
  return select(small, series, select(x < 0.0, -large, large));
}

/// The number in lane i; a double is its own only lane.
/// @{
inline double lane(double a, int) { return a; }
inline double lane(Lanes a, int i) { return a[i]; }
/// @}
/// Sets lane i to v.
/// @{
inline void set_lane(double& a, int, double v) { a = v; }
inline void set_lane(Lanes& a, int i, double v) { a[i] = v; }
/// @}

/// The functions above, for sixteen lanes.
/// @{
inline LanePair select(const LanePairMask& m, const LanePair& x, const LanePair& y) {
  return {select(m.a, x.a, y.a), select(m.b, x.b, y.b)};
}
inline bool any(const LanePairMask& m) { return any(m.a | m.b); }
inline bool all(const LanePairMask& m) { return all(m.a & m.b); }
inline LanePairMask mask_not(const LanePairMask& m) { return {~m.a, ~m.b}; }
inline LanePair max(const LanePair& x, const LanePair& y) { return {max(x.a, y.a), max(x.b, y.b)}; }
inline LanePair min(const LanePair& x, const LanePair& y) { return {min(x.a, y.a), min(x.b, y.b)}; }
inline LanePair abs(const LanePair& x) { return {abs(x.a), abs(x.b)}; }
inline LanePair sqrt(const LanePair& x) { return {sqrt(x.a), sqrt(x.b)}; }
inline LanePair exp(const LanePair& x) { return {exp(x.a), exp(x.b)}; }
inline LanePair log(const LanePair& x) { return {log(x.a), log(x.b)}; }
inline LanePair expm1(const LanePair& x) { return {expm1(x.a), expm1(x.b)}; }
inline LanePair log1p(const LanePair& x) { return {log1p(x.a), log1p(x.b)}; }
inline LanePair sinh(const LanePair& x) { return {sinh(x.a), sinh(x.b)}; }
inline double lane(const LanePair& x, int i) { return i < lane_count ? x.a[i] : x.b[i - lane_count]; }
inline void set_lane(LanePair& x, int i, double v) { set_lane(i < lane_count ? x.a : x.b, i % lane_count, v); }
/// @}

/// How many material points a T holds: 1, 8 or 16.
template <LaneNumber T>
inline constexpr int lanes_of = std::same_as<T, double>  ? 1
                                : std::same_as<T, Lanes> ? lane_count
                                                         : 2 * lane_count;

}  // namespace mpm
