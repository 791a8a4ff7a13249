#pragma once
/// Two registers side by side as one number: `LanePair` = two Lanes, `HalfPair` = two HalfLanes, `SinglePair` = two SingleLanes. The
/// operators and functions of lanes.hpp and lane_math.hpp, for them.

#include "libmpm/base/lane_math.hpp"

namespace mpm {

/// Two registers side by side. A law is one long chain of dependent operations; two independent groups in one stream of
/// instructions hide each other's latency (measured: the yielding law takes a quarter less time, benchmarks/README.md).
template <OneRegister V>
struct PairOf {
  V a, b;  ///< the lower lanes and the upper ones
};
using LanePair = PairOf<Lanes>;          ///< sixteen doubles
using HalfPair = PairOf<HalfLanes>;      ///< eight doubles
using SinglePair = PairOf<SingleLanes>;  ///< thirty-two floats, or sixteen where registers are shorter

/// A pair of registers of floats is computed in single precision, too.
template <>
inline constexpr bool is_single<SinglePair> = true;

/// Result of a comparison of pairs.
template <class M>
struct MaskPairOf {
  M a, b;  ///< of the lower lanes and of the upper ones
};
namespace detail {
template <class V>
struct MaskOf<PairOf<V>> {
  using type = MaskPairOf<Mask<V>>;
};
}  // namespace detail

/// The number types that a law and a tensor can be computed with.
template <class T>
concept LaneNumber = std::same_as<T, double> || std::same_as<T, Lanes> || std::same_as<T, LanePair> || std::same_as<T, HalfPair> ||
    std::same_as<T, SinglePair>;

/// Lane by lane; a scalar operand counts for every lane, rounded to the precision of the lanes.
/// @{
template <OneRegister V>
inline PairOf<V> operator+(const PairOf<V>& x, const PairOf<V>& y) {
  return {x.a + y.a, x.b + y.b};
}
template <OneRegister V>
inline PairOf<V> operator-(const PairOf<V>& x, const PairOf<V>& y) {
  return {x.a - y.a, x.b - y.b};
}
template <OneRegister V>
inline PairOf<V> operator*(const PairOf<V>& x, const PairOf<V>& y) {
  return {x.a * y.a, x.b * y.b};
}
template <OneRegister V>
inline PairOf<V> operator/(const PairOf<V>& x, const PairOf<V>& y) {
  return {x.a / y.a, x.b / y.b};
}
template <OneRegister V>
inline PairOf<V> operator+(const PairOf<V>& x, double y) {
  const auto s = static_cast<ScalarOf<V>>(y);
  return {x.a + s, x.b + s};
}
template <OneRegister V>
inline PairOf<V> operator-(const PairOf<V>& x, double y) {
  const auto s = static_cast<ScalarOf<V>>(y);
  return {x.a - s, x.b - s};
}
template <OneRegister V>
inline PairOf<V> operator*(const PairOf<V>& x, double y) {
  const auto s = static_cast<ScalarOf<V>>(y);
  return {x.a * s, x.b * s};
}
template <OneRegister V>
inline PairOf<V> operator+(double x, const PairOf<V>& y) {
  const auto s = static_cast<ScalarOf<V>>(x);
  return {s + y.a, s + y.b};
}
template <OneRegister V>
inline PairOf<V> operator-(double x, const PairOf<V>& y) {
  const auto s = static_cast<ScalarOf<V>>(x);
  return {s - y.a, s - y.b};
}
template <OneRegister V>
inline PairOf<V> operator*(double x, const PairOf<V>& y) {
  const auto s = static_cast<ScalarOf<V>>(x);
  return {s * y.a, s * y.b};
}
template <OneRegister V>
inline PairOf<V> operator/(double x, const PairOf<V>& y) {
  const auto s = static_cast<ScalarOf<V>>(x);
  return {s / y.a, s / y.b};
}
template <OneRegister V>
inline PairOf<V> operator-(const PairOf<V>& x) {
  return {-x.a, -x.b};
}
template <OneRegister V>
inline PairOf<V>& operator+=(PairOf<V>& x, const PairOf<V>& y) {
  return x = x + y;
}
template <OneRegister V>
inline PairOf<V>& operator*=(PairOf<V>& x, const PairOf<V>& y) {
  return x = x * y;
}
template <OneRegister V>
inline Mask<PairOf<V>> operator<(const PairOf<V>& x, const PairOf<V>& y) {
  return {is_less(x.a, y.a), is_less(x.b, y.b)};
}
template <OneRegister V>
inline Mask<PairOf<V>> operator<=(const PairOf<V>& x, const PairOf<V>& y) {
  return {is_at_most(x.a, y.a), is_at_most(x.b, y.b)};
}
template <OneRegister V>
inline Mask<PairOf<V>> operator>(const PairOf<V>& x, const PairOf<V>& y) {
  return {is_less(y.a, x.a), is_less(y.b, x.b)};
}
template <OneRegister V>
inline Mask<PairOf<V>> operator<(const PairOf<V>& x, double y) {
  return x < PairOf<V>{} + y;
}
template <OneRegister V>
inline Mask<PairOf<V>> operator<=(const PairOf<V>& x, double y) {
  return x <= PairOf<V>{} + y;
}
template <OneRegister V>
inline Mask<PairOf<V>> operator>(const PairOf<V>& x, double y) {
  return x > PairOf<V>{} + y;
}
template <OneRegister V>
inline Mask<PairOf<V>> operator>=(const PairOf<V>& x, double y) {
  return PairOf<V>{} + y <= x;
}
template <class M>
inline MaskPairOf<M> operator&(const MaskPairOf<M>& x, const MaskPairOf<M>& y) {
  return {x.a & y.a, x.b & y.b};
}
template <class M>
inline MaskPairOf<M> operator|(const MaskPairOf<M>& x, const MaskPairOf<M>& y) {
  return {x.a | y.a, x.b | y.b};
}
/// @}

/// A pair of registers of doubles: as many numbers as a register of floats holds.
using WidePair = PairOf<DoubleLanes>;
/// A register of floats in double precision, and back.
/// @{
inline WidePair widen(SingleLanes a) {
#if defined(__AVX512F__)
  using Eight = float __attribute__((vector_size(32)));
  const Eight low = __builtin_shufflevector(a, a, 0, 1, 2, 3, 4, 5, 6, 7),
              high = __builtin_shufflevector(a, a, 8, 9, 10, 11, 12, 13, 14, 15);
  return {__builtin_convertvector(low, Lanes), __builtin_convertvector(high, Lanes)};
#else
  return {widen(__builtin_shufflevector(a, a, 0, 1, 2, 3)), widen(__builtin_shufflevector(a, a, 4, 5, 6, 7))};
#endif
}
inline SingleLanes narrow(const WidePair& a) {
#if defined(__AVX512F__)
  using Eight = float __attribute__((vector_size(32)));
  const Eight low = __builtin_convertvector(a.a, Eight), high = __builtin_convertvector(a.b, Eight);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#else
  return __builtin_shufflevector(narrow(a.a), narrow(a.b), 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}
/// @}

/// The functions of lanes.hpp and lane_math.hpp.
/// @{
template <OneRegister V>
inline PairOf<V> select(const Mask<PairOf<V>>& m, const PairOf<V>& x, const PairOf<V>& y) {
  return {select(m.a, x.a, y.a), select(m.b, x.b, y.b)};
}
template <class M>
inline bool any(const MaskPairOf<M>& m) {
  return any(m.a | m.b);
}
template <class M>
inline bool all(const MaskPairOf<M>& m) {
  return all(m.a & m.b);
}
template <class M>
inline MaskPairOf<M> mask_not(const MaskPairOf<M>& m) {
  return {~m.a, ~m.b};
}
template <OneRegister V>
inline PairOf<V> max(const PairOf<V>& x, const PairOf<V>& y) {
  return {max(x.a, y.a), max(x.b, y.b)};
}
template <OneRegister V>
inline PairOf<V> min(const PairOf<V>& x, const PairOf<V>& y) {
  return {min(x.a, y.a), min(x.b, y.b)};
}
template <OneRegister V>
inline PairOf<V> abs(const PairOf<V>& x) {
  return {abs(x.a), abs(x.b)};
}
template <OneRegister V>
inline PairOf<V> sqrt(const PairOf<V>& x) {
  return {sqrt(x.a), sqrt(x.b)};
}
template <OneRegister V>
inline PairOf<V> exp(const PairOf<V>& x) {
  return {exp(x.a), exp(x.b)};
}
template <OneRegister V>
inline PairOf<V> log(const PairOf<V>& x) {
  return {log(x.a), log(x.b)};
}
template <OneRegister V>
inline PairOf<V> expm1(const PairOf<V>& x) {
  return {expm1(x.a), expm1(x.b)};
}
template <OneRegister V>
inline PairOf<V> log1p(const PairOf<V>& x) {
  return {log1p(x.a), log1p(x.b)};
}
template <OneRegister V>
inline PairOf<V> sinh(const PairOf<V>& x) {
  return {sinh(x.a), sinh(x.b)};
}
template <OneRegister V>
inline double lane(const PairOf<V>& x, int i) {
  constexpr int half = sizeof(V) / sizeof(ScalarOf<V>);
  return double{i < half ? x.a[i] : x.b[i - half]};
}
template <OneRegister V>
inline void set_lane(PairOf<V>& x, int i, double v) {
  constexpr int half = sizeof(V) / sizeof(ScalarOf<V>);
  if (i < half) {
    x.a[i] = static_cast<ScalarOf<V>>(v);
  } else {
    x.b[i - half] = static_cast<ScalarOf<V>>(v);
  }
}
/// @}

}  // namespace mpm
