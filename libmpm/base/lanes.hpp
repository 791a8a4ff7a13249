#pragma once
/// The number types of the kernels: `double`, `Lanes` = eight doubles computed at once, and `SingleLanes` = sixteen floats. Two of them
/// side by side are in lane_pair.hpp.
///
/// `Lanes` is a GCC/Clang vector extension: + - * / and comparisons work on it as on a scalar, and the compiler maps it
/// to one AVX-512, two AVX or four SSE2 registers. The functions below exist for all types, so that a template over the
/// number type reads the same for one material point and for many; branches become `select`.

#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "libmpm/base/registers.hpp"
#include "libmpm/base/types.hpp"

namespace mpm {

/// One number in all lanes of one register.
template <class V>
concept OneRegister = std::same_as<V, Lanes> || std::same_as<V, SingleLanes>;
/// double or float: what the lanes of a V are.
template <OneRegister V>
using ScalarOf = std::conditional_t<std::same_as<V, Lanes>, double, float>;

/// {a, b}: lanes 0 to 3 from a, 4 to 7 from b.
inline Lanes join(HalfLanes a, HalfLanes b) {
  if constexpr (whole_registers) {
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  } else {
    return from_halves<Lanes>(a, b);
  }
}
/// Lanes 0 to 3, and 4 to 7.
/// @{
inline HalfLanes lower_half(const Lanes& v) { return half(v, 0); }
inline HalfLanes upper_half(const Lanes& v) { return half(v, 1); }
/// @}

/// Whether a T computes in single precision.
template <class T>
inline constexpr bool is_single = std::same_as<T, SingleLanes>;
/// A number that a T needs another value of in single precision: a tolerance, the order of a series.
template <class T, class Value>
constexpr Value by_precision(Value in_double, Value in_single) {
  return is_single<T> ? in_single : in_double;
}

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
struct MaskOf<SingleLanes> {
  using type = SingleLaneMask;
};
}  // namespace detail
/// What a comparison of two T gives.
template <class T>
using Mask = typename detail::MaskOf<T>::type;

/// The same value in every lane.
template <class T>
inline T broadcast(double a) {
  return T{} + a;
}

/// How many material points a T holds: 1, 8, 16 or 32.
template <class T>
inline constexpr int lanes_of = std::same_as<T, double> ? 1 : static_cast<int>(sizeof(T) / (is_single<T> ? sizeof(float) : sizeof(double)));

/// a where m is true, else b; lane by lane. Both are evaluated.
/// @{
inline double select(bool m, double a, double b) { return m ? a : b; }
inline Lanes select(const LaneMask& m, const Lanes& a, const Lanes& b) {
  return by_halves<Lanes>([](auto x, auto y, auto z) { return x ? y : z; }, m, a, b);
}
inline SingleLanes select(const SingleLaneMask& m, const SingleLanes& a, const SingleLanes& b) {
  return by_halves<SingleLanes>([](auto x, auto y, auto z) { return x ? y : z; }, m, a, b);
}
/// @}
/// Comparisons of registers; the operators do the same.
/// @{
template <OneRegister V>
inline Mask<V> is_less(const V& x, const V& y) {
  return by_halves<Mask<V>>([](auto a, auto b) { return a < b; }, x, y);
}
template <OneRegister V>
inline Mask<V> is_at_most(const V& x, const V& y) {
  return by_halves<Mask<V>>([](auto a, auto b) { return a <= b; }, x, y);
}
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
  const auto either = half(m, 0) | half(m, 1);
#if defined(__AVX__)
  return _mm256_testz_si256(reinterpret_cast<__m256i>(either), reinterpret_cast<__m256i>(either)) == 0;
#else
  return (either[0] | either[1] | either[2] | either[3]) != 0;
#endif
#endif
}
/// Whether m is true in every lane.
inline bool all(LaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) == 0xFF;
#else
  return !any(~m);
#endif
}
/// Whether m is true in some lane.
inline bool any(SingleLaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) != 0;
#else
  const auto halves = std::bit_cast<LaneMask>(m);
  return any(halves);
#endif
}
/// Whether m is true in every lane.
inline bool all(SingleLaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) == 0xFFFF;
#else
  return !any(~m);
#endif
}
/// The opposite, lane by lane.
/// @{
inline bool mask_not(bool m) { return !m; }
inline LaneMask mask_not(LaneMask m) { return ~m; }
inline SingleLaneMask mask_not(SingleLaneMask m) { return ~m; }
/// @}

/// Lane by lane. Where an operand of max or min is NaN, the result is b.
/// @{
inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
template <OneRegister V>
inline V max(const V& a, const V& b) {
  return by_halves<V>([](auto x, auto y) { return x > y ? x : y; }, a, b);
}
template <OneRegister V>
inline V min(const V& a, const V& b) {
  return by_halves<V>([](auto x, auto y) { return x < y ? x : y; }, a, b);
}
inline double abs(double a) { return std::fabs(a); }
inline Lanes abs(Lanes a) { return std::bit_cast<Lanes>(std::bit_cast<LaneMask>(a) & std::int64_t{0x7FFFFFFFFFFFFFFF}); }
inline SingleLanes abs(SingleLanes a) { return std::bit_cast<SingleLanes>(std::bit_cast<SingleLaneMask>(a) & 0x7FFFFFFF); }
/// @}

/// Square root, lane by lane; NaN for a negative number.
/// @{
inline double sqrt(double a) { return std::sqrt(a); }
inline Lanes sqrt(Lanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<Lanes>(_mm512_maskz_sqrt_pd(0xFF, reinterpret_cast<__m512d>(a)));
#else
  return by_halves<Lanes>(
      [](auto v) {
        for (int i = 0; i < 4; ++i) v[i] = std::sqrt(v[i]);
        return v;
      },
      a);
#endif
}
inline SingleLanes sqrt(SingleLanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<SingleLanes>(_mm512_maskz_sqrt_ps(0xFFFF, reinterpret_cast<__m512>(a)));
#else
  SingleLanes r;
  for (int i = 0; i < 2 * lane_count; ++i) r[i] = std::sqrt(a[i]);
  return r;
#endif
}
/// @}

/// The nearest integers, ties to even; the smallest integer where a number is out of range or none.
inline SingleLaneMask nearest_integers(SingleLanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<SingleLaneMask>(_mm512_maskz_cvtps_epi32(0xFFFF, reinterpret_cast<__m512>(a)));
#else
#if defined(__AVX__)
  const auto nearest = [](HalfOf<SingleLanes> v) {
    return reinterpret_cast<HalfOf<SingleLaneMask>>(_mm256_cvtps_epi32(reinterpret_cast<__m256>(v)));
  };
  return from_halves<SingleLaneMask>(nearest(half(a, 0)), nearest(half(a, 1)));
#else
  __m128 from[4];
  __m128i to[4];
  std::memcpy(from, &a, sizeof a);
  for (int i = 0; i < 4; ++i) to[i] = _mm_cvtps_epi32(from[i]);
  SingleLaneMask r;
  std::memcpy(&r, to, sizeof r);
  return r;
#endif
#endif
}

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
/// Sixteen integers as signed bytes: four in each word, lane 0 lowest; what does not fit becomes the nearest that does.
inline std::array<std::uint32_t, 4> saturated_bytes(SingleLaneMask a) {
  std::array<std::uint32_t, 4> words{};
#if defined(__AVX512F__)
  const __m128i bytes = _mm512_maskz_cvtsepi32_epi8(0xFFFF, reinterpret_cast<__m512i>(a));
  std::memcpy(words.data(), &bytes, sizeof words);
#else
  __m128i part[4];
  std::memcpy(part, &a, sizeof part);
  const __m128i bytes = _mm_packs_epi16(_mm_packs_epi32(part[0], part[1]), _mm_packs_epi32(part[2], part[3]));
  std::memcpy(words.data(), &bytes, sizeof words);
#endif
  return words;
}

namespace detail {
// glibc's vector mathematics (libmvec, at most 4 ulp), called by its published x86 vector-ABI names: no -ffast-math needed.
// NOLINTBEGIN(bugprone-reserved-identifier): the ABI gives the names
#if defined(__AVX512F__)
extern "C" __m512d _ZGVeN8v_exp(__m512d);
extern "C" __m512d _ZGVeN8v_log(__m512d);
inline Lanes mvec_exp(const Lanes& x) { return reinterpret_cast<Lanes>(_ZGVeN8v_exp(reinterpret_cast<__m512d>(x))); }
inline Lanes mvec_log(const Lanes& x) { return reinterpret_cast<Lanes>(_ZGVeN8v_log(reinterpret_cast<__m512d>(x))); }
extern "C" __m512 _ZGVeN16v_expf(__m512);
extern "C" __m512 _ZGVeN16v_logf(__m512);
inline SingleLanes mvec_exp(const SingleLanes& x) { return reinterpret_cast<SingleLanes>(_ZGVeN16v_expf(reinterpret_cast<__m512>(x))); }
inline SingleLanes mvec_log(const SingleLanes& x) { return reinterpret_cast<SingleLanes>(_ZGVeN16v_logf(reinterpret_cast<__m512>(x))); }
#else
#if defined(__AVX2__)
using MvecPart = __m256d;
extern "C" __m256d _ZGVdN4v_exp(__m256d);
extern "C" __m256d _ZGVdN4v_log(__m256d);
inline MvecPart mvec_exp(MvecPart x) { return _ZGVdN4v_exp(x); }
inline MvecPart mvec_log(MvecPart x) { return _ZGVdN4v_log(x); }
using SingleMvecPart = __m256;
extern "C" __m256 _ZGVdN8v_expf(__m256);
extern "C" __m256 _ZGVdN8v_logf(__m256);
inline SingleMvecPart mvec_exp(SingleMvecPart x) { return _ZGVdN8v_expf(x); }
inline SingleMvecPart mvec_log(SingleMvecPart x) { return _ZGVdN8v_logf(x); }
#else
using MvecPart = __m128d;
extern "C" __m128d _ZGVbN2v_exp(__m128d);
extern "C" __m128d _ZGVbN2v_log(__m128d);
inline MvecPart mvec_exp(MvecPart x) { return _ZGVbN2v_exp(x); }
inline MvecPart mvec_log(MvecPart x) { return _ZGVbN2v_log(x); }
using SingleMvecPart = __m128;
extern "C" __m128 _ZGVbN4v_expf(__m128);
extern "C" __m128 _ZGVbN4v_logf(__m128);
inline SingleMvecPart mvec_exp(SingleMvecPart x) { return _ZGVbN4v_expf(x); }
inline SingleMvecPart mvec_log(SingleMvecPart x) { return _ZGVbN4v_logf(x); }
#endif
// NOLINTEND(bugprone-reserved-identifier)
template <class Part, class V, class F>
inline V in_parts(const V& x, F f) {
  Part part[sizeof(V) / sizeof(Part)];
  std::memcpy(part, &x, sizeof x);
  for (Part& p : part) p = f(p);
  V r;
  std::memcpy(&r, part, sizeof r);
  return r;
}
inline Lanes mvec_exp(const Lanes& x) {
  return in_parts<MvecPart>(x, [](MvecPart p) { return mvec_exp(p); });
}
inline Lanes mvec_log(const Lanes& x) {
  return in_parts<MvecPart>(x, [](MvecPart p) { return mvec_log(p); });
}
inline SingleLanes mvec_exp(const SingleLanes& x) {
  return in_parts<SingleMvecPart>(x, [](SingleMvecPart p) { return mvec_exp(p); });
}
inline SingleLanes mvec_log(const SingleLanes& x) {
  return in_parts<SingleMvecPart>(x, [](SingleMvecPart p) { return mvec_log(p); });
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
/// In lanes a truncated power series (truncation below 1e-16 of the value inside the stated radius, 1e-8 in single precision) serves small
/// arguments; libmvec is called only if some lane is outside the radius.
/// @{
inline double exp(double x) { return std::exp(x); }
inline double log(double x) { return std::log(x); }
inline double expm1(double x) { return std::expm1(x); }
inline double log1p(double x) { return std::log1p(x); }
inline double sinh(double x) { return std::sinh(x); }
template <OneRegister V>
inline V exp(const V& x) {
  return detail::mvec_exp(x);
}
template <OneRegister V>
inline V log(const V& x) {
  return detail::mvec_log(x);
}
/// @}
namespace detail {
/// sum_{k=0}^{terms-1} f(k) x^k by Horner, unrolled.
template <int terms, OneRegister V, class Coefficient>
inline V horner(const V& x, Coefficient f) {
  V sum = V{} + static_cast<ScalarOf<V>>(f(terms - 1));
#pragma GCC unroll 16
  for (int k = terms - 2; k >= 0; --k) sum = static_cast<ScalarOf<V>>(f(k)) + sum * x;
  return sum;
}
template <OneRegister V>
inline auto at_most(const V& x, double bound) {
  return is_at_most(x, V{} + static_cast<ScalarOf<V>>(bound));
}
}  // namespace detail
/// e^x - 1, to relative precision.
template <OneRegister V>
inline V expm1(const V& x) {
  constexpr auto coefficient = [](int k) { return detail::inverse_factorial(k + 1); };
  const V magnitude = abs(x);
  if (all(detail::at_most(magnitude, 0.05))) return x * detail::horner<by_precision<V>(9, 4)>(x, coefficient);  // 0.05^9 / 10! = 5e-19
  const V series = x * detail::horner<by_precision<V>(13, 7)>(x, coefficient);                                  // 0.35^13 / 14! = 1.4e-17
  const auto small = detail::at_most(magnitude, 0.35);
  if (all(small)) return series;
  return select(small, series, detail::mvec_exp(x) - 1.0);
}
/// log(1 + x), to relative precision.
template <OneRegister V>
inline V log1p(const V& x) {
  constexpr auto coefficient = [](int k) { return 2.0 / (2 * k + 1); };  // 2 artanh(z) = 2 (z + z^3/3 + z^5/5 + ...)
  const V z = x / (2.0 + x), z2 = z * z, magnitude = abs(x);
  if (all(detail::at_most(magnitude, 0.05)))
    return z * detail::horner<by_precision<V>(6, 3)>(z2, coefficient);           // |z| <= 0.0257: 0.0257^12 / 13 = 6e-21
  const V series = z * detail::horner<by_precision<V>(12, 6)>(z2, coefficient);  // |z| <= 0.213: 0.213^24 / 25 = 3e-18
  const auto small = detail::at_most(magnitude, 0.35);
  if (all(small)) return series;
  return select(small, series, detail::mvec_log(1.0 + x));
}
/// To relative precision.
template <OneRegister V>
inline V sinh(const V& x) {
  constexpr auto coefficient = [](int k) { return detail::inverse_factorial(2 * k + 1); };
  const V x2 = x * x, magnitude = abs(x);
  if (all(detail::at_most(magnitude, 0.1))) return x * detail::horner<by_precision<V>(5, 3)>(x2, coefficient);  // 0.1^10 / 11! = 3e-18
  const V series = x * detail::horner<by_precision<V>(8, 5)>(x2, coefficient);                                  // 0.5^16 / 17! = 4e-20
  const auto small = detail::at_most(magnitude, 0.5);
  if (all(small)) return series;
  const V e = detail::mvec_exp(magnitude), large = 0.5 * (e - 1.0 / e);
  return select(small, series, select(is_less(x, V{}), -large, large));
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

}  // namespace mpm
