#pragma once
/// Two registers side by side as one number: `LanePair` = two Lanes, `HalfPair` = two HalfLanes, `SinglePair` = two SingleLanes. The
/// operators and functions of lanes.hpp and lane_math.hpp, for them.

#include "libmpm/base/lane_math.hpp"

namespace mpm {

/// Result of a comparison of pairs. Its functions are those of lanes.hpp.
template <class M>
struct MaskPairOf {
  M a, b;  ///< of the lower lanes and of the upper ones

  /// Lane by lane.
  /// @{
  friend MaskPairOf operator&(const MaskPairOf& x, const MaskPairOf& y) { return {x.a & y.a, x.b & y.b}; }
  friend MaskPairOf operator|(const MaskPairOf& x, const MaskPairOf& y) { return {x.a | y.a, x.b | y.b}; }
  friend MaskPairOf mask_not(const MaskPairOf& m) { return {~m.a, ~m.b}; }
  friend bool any(const MaskPairOf& m) { return any(m.a | m.b); }
  friend bool all(const MaskPairOf& m) { return all(m.a & m.b); }
  /// @}
};

/// Two registers side by side. A law is one long chain of dependent operations; two independent groups in one stream of
/// instructions hide each other's latency (measured: the yielding law takes a quarter less time, benchmarks/README.md).
template <OneRegister V>
struct PairOf {
  using S = ScalarOf<V>;          ///< a lane
  using M = MaskPairOf<Mask<V>>;  ///< result of a comparison
  V a, b;                         ///< the lower lanes and the upper ones

  /// Lane by lane; a scalar operand counts for every lane, rounded to the precision of the lanes.
  /// @{
  friend PairOf operator+(const PairOf& x, const PairOf& y) { return {x.a + y.a, x.b + y.b}; }
  friend PairOf operator-(const PairOf& x, const PairOf& y) { return {x.a - y.a, x.b - y.b}; }
  friend PairOf operator*(const PairOf& x, const PairOf& y) { return {x.a * y.a, x.b * y.b}; }
  friend PairOf operator/(const PairOf& x, const PairOf& y) { return {x.a / y.a, x.b / y.b}; }
  friend PairOf operator+(const PairOf& x, double y) { return {x.a + static_cast<S>(y), x.b + static_cast<S>(y)}; }
  friend PairOf operator-(const PairOf& x, double y) { return {x.a - static_cast<S>(y), x.b - static_cast<S>(y)}; }
  friend PairOf operator*(const PairOf& x, double y) { return {x.a * static_cast<S>(y), x.b * static_cast<S>(y)}; }
  friend PairOf operator+(double x, const PairOf& y) { return {static_cast<S>(x) + y.a, static_cast<S>(x) + y.b}; }
  friend PairOf operator-(double x, const PairOf& y) { return {static_cast<S>(x) - y.a, static_cast<S>(x) - y.b}; }
  friend PairOf operator*(double x, const PairOf& y) { return {static_cast<S>(x) * y.a, static_cast<S>(x) * y.b}; }
  friend PairOf operator/(double x, const PairOf& y) { return {static_cast<S>(x) / y.a, static_cast<S>(x) / y.b}; }
  friend PairOf operator-(const PairOf& x) { return {-x.a, -x.b}; }
  friend PairOf& operator+=(PairOf& x, const PairOf& y) { return x = x + y; }
  friend PairOf& operator*=(PairOf& x, const PairOf& y) { return x = x * y; }
  friend M operator<(const PairOf& x, const PairOf& y) { return {is_less(x.a, y.a), is_less(x.b, y.b)}; }
  friend M operator<=(const PairOf& x, const PairOf& y) { return {is_at_most(x.a, y.a), is_at_most(x.b, y.b)}; }
  friend M operator>(const PairOf& x, const PairOf& y) { return {is_less(y.a, x.a), is_less(y.b, x.b)}; }
  friend M operator<(const PairOf& x, double y) { return x < PairOf{} + y; }
  friend M operator<=(const PairOf& x, double y) { return x <= PairOf{} + y; }
  friend M operator>(const PairOf& x, double y) { return x > PairOf{} + y; }
  friend M operator>=(const PairOf& x, double y) { return PairOf{} + y <= x; }
  /// @}

  /// The functions of lanes.hpp and lane_math.hpp.
  /// @{
  friend PairOf select(const M& m, const PairOf& x, const PairOf& y) { return {select(m.a, x.a, y.a), select(m.b, x.b, y.b)}; }
  friend PairOf max(const PairOf& x, const PairOf& y) { return {max(x.a, y.a), max(x.b, y.b)}; }
  friend PairOf min(const PairOf& x, const PairOf& y) { return {min(x.a, y.a), min(x.b, y.b)}; }
  friend PairOf abs(const PairOf& x) { return {abs(x.a), abs(x.b)}; }
  friend PairOf sqrt(const PairOf& x) { return {sqrt(x.a), sqrt(x.b)}; }
  friend PairOf exp(const PairOf& x) { return {exp(x.a), exp(x.b)}; }
  friend PairOf log(const PairOf& x) { return {log(x.a), log(x.b)}; }
  friend PairOf expm1(const PairOf& x) { return {expm1(x.a), expm1(x.b)}; }
  friend PairOf log1p(const PairOf& x) { return {log1p(x.a), log1p(x.b)}; }
  friend PairOf sinh(const PairOf& x) { return {sinh(x.a), sinh(x.b)}; }
  friend double lane(const PairOf& x, int i) { return double{i < half_lanes ? x.a[i] : x.b[i - half_lanes]}; }
  friend void set_lane(PairOf& x, int i, double v) {
    if (i < half_lanes) {
      x.a[i] = static_cast<S>(v);
    } else {
      x.b[i - half_lanes] = static_cast<S>(v);
    }
  }
  /// @}

  static constexpr int half_lanes = sizeof(V) / sizeof(S);  ///< lanes of one of the two registers
};
using LanePair = PairOf<Lanes>;          ///< sixteen doubles
using HalfPair = PairOf<HalfLanes>;      ///< eight doubles
using SinglePair = PairOf<SingleLanes>;  ///< thirty-two floats, or sixteen where registers are shorter

/// A pair of registers of floats is computed in single precision, too.
template <>
inline constexpr bool is_single<SinglePair> = true;

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

}  // namespace mpm
