#pragma once
/// exp, log, expm1, log1p and sinh for the number types of lanes.hpp.

#include <array>
#include <cmath>
#include <cstring>

#include "libmpm/base/lanes.hpp"

namespace mpm {

namespace detail {
// glibc's vector mathematics (libmvec, at most 4 ulp), called by its published x86 vector-ABI names: no -ffast-math needed.
// NOLINTBEGIN(bugprone-reserved-identifier): the ABI gives the names
template <class Scalar>
struct MvecPart;
#if defined(__AVX2__)
template <>
struct MvecPart<double> {
  using type = __m256d;
  static constexpr int lanes = 4;
};
template <>
struct MvecPart<float> {
  using type = __m256;
  static constexpr int lanes = 8;
};
extern "C" __m256d _ZGVdN4v_exp(__m256d);
extern "C" __m256d _ZGVdN4v_log(__m256d);
inline __m256d part_exp(__m256d x) { return _ZGVdN4v_exp(x); }
inline __m256d part_log(__m256d x) { return _ZGVdN4v_log(x); }
extern "C" __m256 _ZGVdN8v_expf(__m256);
extern "C" __m256 _ZGVdN8v_logf(__m256);
inline __m256 part_exp(__m256 x) { return _ZGVdN8v_expf(x); }
inline __m256 part_log(__m256 x) { return _ZGVdN8v_logf(x); }
#else
template <>
struct MvecPart<double> {
  using type = __m128d;
  static constexpr int lanes = 2;
};
template <>
struct MvecPart<float> {
  using type = __m128;
  static constexpr int lanes = 4;
};
extern "C" __m128d _ZGVbN2v_exp(__m128d);
extern "C" __m128d _ZGVbN2v_log(__m128d);
inline __m128d part_exp(__m128d x) { return _ZGVbN2v_exp(x); }
inline __m128d part_log(__m128d x) { return _ZGVbN2v_log(x); }
extern "C" __m128 _ZGVbN4v_expf(__m128);
extern "C" __m128 _ZGVbN4v_logf(__m128);
inline __m128 part_exp(__m128 x) { return _ZGVbN4v_expf(x); }
inline __m128 part_log(__m128 x) { return _ZGVbN4v_logf(x); }
#endif
#if defined(__AVX512F__)
extern "C" __m512d _ZGVeN8v_exp(__m512d);
extern "C" __m512d _ZGVeN8v_log(__m512d);
extern "C" __m512 _ZGVeN16v_expf(__m512);
extern "C" __m512 _ZGVeN16v_logf(__m512);
#endif
// NOLINTEND(bugprone-reserved-identifier)
/// The parts of a register that one call takes.
template <OneRegister V>
using MvecPartOf = typename MvecPart<ScalarOf<V>>::type;
template <OneRegister V, class F>
inline V in_parts(const V& x, F f) {
  MvecPartOf<V> part[lanes_of<V> / MvecPart<ScalarOf<V>>::lanes];
  std::memcpy(part, &x, sizeof x);
  for (auto& p : part) p = f(p);
  V r;
  std::memcpy(&r, part, sizeof r);
  return r;
}
template <OneRegister V>
inline V mvec_exp(const V& x) {
  return in_parts(x, [](MvecPartOf<V> p) { return part_exp(p); });
}
template <OneRegister V>
inline V mvec_log(const V& x) {
  return in_parts(x, [](MvecPartOf<V> p) { return part_log(p); });
}
#if defined(__AVX512F__)
template <>
inline Lanes mvec_exp(const Lanes& x) {
  return reinterpret_cast<Lanes>(_ZGVeN8v_exp(reinterpret_cast<__m512d>(x)));
}
template <>
inline Lanes mvec_log(const Lanes& x) {
  return reinterpret_cast<Lanes>(_ZGVeN8v_log(reinterpret_cast<__m512d>(x)));
}
template <>
inline SingleLanes mvec_exp(const SingleLanes& x) {
  return reinterpret_cast<SingleLanes>(_ZGVeN16v_expf(reinterpret_cast<__m512>(x)));
}
template <>
inline SingleLanes mvec_log(const SingleLanes& x) {
  return reinterpret_cast<SingleLanes>(_ZGVeN16v_logf(reinterpret_cast<__m512>(x)));
}
#endif

/// 1/n!, by table: constants that the compiler folds into the unrolled series.
inline constexpr auto inverse_factorials = [] {
  std::array<double, 18> table{1.0};
  for (std::size_t n = 1; n < table.size(); ++n) table[n] = table[n - 1] / static_cast<double>(n);
  return table;
}();
constexpr double inverse_factorial(int n) { return inverse_factorials[static_cast<std::size_t>(n)]; }
}  // namespace detail

/// exp, log, and three that keep relative precision for any small argument: expm1(x) = e^x - 1, log1p(x) = log(1 + x), sinh(x).
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

}  // namespace mpm
