#pragma once
/// 3x3 tensors over the number types of lanes.hpp: the operations that the laws need, including the trial step in logarithmic (Hencky)
/// strain.

#include <limits>

#include "libmpm/base/lane_pair.hpp"
#include "libmpm/base/types.hpp"

namespace mpm {

/// General 3x3 matrix, m[row][column].
template <LaneNumber T>
struct Matrix3 {
  T m[3][3];  ///< [row][column]
};

/// Symmetric 3x3 tensor.
template <LaneNumber T>
struct Sym3 {
  T xx, yy, zz, xy, xz, yz;  ///< the six independent components, in this order everywhere

  /// Component by component.
  /// @{
  friend Sym3 operator+(const Sym3& a, const Sym3& b) {
    return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
  }
  friend Sym3 operator-(const Sym3& a, const Sym3& b) {
    return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.xz - b.xz, a.yz - b.yz};
  }
  friend Sym3 operator*(T s, const Sym3& a) { return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz}; }
  /// @}
  /// tr a
  friend T trace(const Sym3& a) { return a.xx + a.yy + a.zz; }
  /// a : a
  friend T norm2(const Sym3& a) { return a.xx * a.xx + a.yy * a.yy + a.zz * a.zz + 2.0 * (a.xy * a.xy + a.xz * a.xz + a.yz * a.yz); }
  /// a - 1/3 tr(a) I
  friend Sym3 deviator(const Sym3& a) {
    const T mean = trace(a) * (1.0 / 3.0);
    return {a.xx - mean, a.yy - mean, a.zz - mean, a.xy, a.xz, a.yz};
  }
  /// det a
  friend T determinant(const Sym3& a) {
    return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.xz * a.yz) + a.xz * (a.xy * a.yz - a.xz * a.yy);
  }
  /// A A, symmetric because a tensor commutes with itself.
  friend Sym3 square(const Sym3& a) {
    return {a.xx * a.xx + a.xy * a.xy + a.xz * a.xz, a.xy * a.xy + a.yy * a.yy + a.yz * a.yz, a.xz * a.xz + a.yz * a.yz + a.zz * a.zz,
            a.xy * (a.xx + a.yy) + a.xz * a.yz,      a.xz * (a.xx + a.zz) + a.xy * a.yz,      a.yz * (a.yy + a.zz) + a.xy * a.xz};
  }
};

/// Strain split into its trace and its deviator: the laws use both, and the series below need fewer terms.
template <LaneNumber T>
struct HenckyStrain {
  T volumetric;      ///< tr eps, expansion positive
  Sym3<T> deviator;  ///< eps - 1/3 tr eps I
};

/// exp(a) - I of any matrix; small exponents keep their digits.
[[nodiscard]] Mat3 exp_minus_identity(const Mat3& a);

namespace detail {

/// exp(A) - I and 1/2 log(I + A) by eigenvalues: any symmetric A, for the rare lane outside the series' radius.
/// NaN in every component where A is not finite, or where I + A is not positive definite (logarithm).
Sym3<double> exp_minus_identity_by_eigenvalues(const Sym3<double>& a);
Sym3<double> half_log_identity_plus_by_eigenvalues(const Sym3<double>& a);

/// c0 I + c1 A + c2 A^2 for a traceless symmetric A.
template <LaneNumber T>
struct Quadratic {
  T c0, c1, c2;
};

/// sum_{k=1}^{order} f(k) A^k of a traceless A, by Horner on the three coefficients: A^3 = J2 A + J3 I (Cayley-Hamilton), J2 = 1/2 A:A,
/// J3 = det A, so that (c0, c1, c2) A = (c2 J3, c0 + c2 J2, c1): two multiply-adds an order instead of a matrix product.
template <int order, LaneNumber T, class Coefficient>
inline Quadratic<T> power_series(const T& j2, const T& j3, Coefficient f) {
  Quadratic<T> s{broadcast<T>(f(order)), T{}, T{}};
#pragma GCC unroll 32
  for (int k = order - 1; k >= 0; --k) s = {s.c2 * j3 + (k > 0 ? f(k) : 0.0), s.c0 + s.c2 * j2, s.c1};
  return s;
}

// Largest |eigenvalue| of a traceless A: lambda^2 <= 2/3 A:A = 4/3 J2. The two radii of the series, and J2 at them.
inline constexpr double short_radius = 0.06, long_radius = 0.3;
inline constexpr double short_j2 = 0.75 * short_radius * short_radius, long_j2 = 0.75 * long_radius * long_radius;

/// A^2, J2 and J3 of a traceless A.
template <LaneNumber T>
struct TracelessPowers {
  Sym3<T> a2;
  T j2, j3;
  explicit TracelessPowers(const Sym3<T>& a) : a2(square(a)), j2(0.5 * trace(a2)), j3(determinant(a)) {}
};

template <LaneNumber T>
inline Sym3<T> evaluate(const Quadratic<T>& s, const Sym3<T>& a, const Sym3<T>& a2) {
  return {s.c0 + s.c1 * a.xx + s.c2 * a2.xx, s.c0 + s.c1 * a.yy + s.c2 * a2.yy, s.c0 + s.c1 * a.zz + s.c2 * a2.zz,
          s.c1 * a.xy + s.c2 * a2.xy,        s.c1 * a.xz + s.c2 * a2.xz,        s.c1 * a.yz + s.c2 * a2.yz};
}

/// Replaces the result in the lanes where `keep` is false by what `exact` gives for that lane.
template <LaneNumber T, class Exact>
inline void replace_lanes(const Mask<T>& keep, const Sym3<T>& a, Sym3<T>& result, Exact exact) {
  const T kept = select(keep, broadcast<T>(1.0), T{});
  for (int i = 0; i < lanes_of<T>; ++i) {
    if (lane(kept, i) != 0.0) continue;
    const Sym3<double> r = exact({lane(a.xx, i), lane(a.yy, i), lane(a.zz, i), lane(a.xy, i), lane(a.xz, i), lane(a.yz, i)});
    set_lane(result.xx, i, r.xx), set_lane(result.yy, i, r.yy), set_lane(result.zz, i, r.zz);
    set_lane(result.xy, i, r.xy), set_lane(result.xz, i, r.xz), set_lane(result.yz, i, r.yz);
  }
}

}  // namespace detail

/// B = exp(2 eps) - I, the left Cauchy-Green tensor less the identity, without the loss of small strains in 1 + 2 eps.
/// Coded: with v = 2/3 tr eps and A = 2 dev eps, B = (e^v - 1) I + e^v (exp A - I); exp A - I by its power series in Cayley-Hamilton
/// form. Truncation relative to A: 5e-16 at order 8 and radius 0.06, 9e-17 at order 12 and radius 0.3; in single precision 1e-7 at order 4,
/// 1.5e-7 at order 6; beyond by eigenvalues.
template <LaneNumber T>
inline __attribute__((always_inline)) Sym3<T> exp_minus_identity(const HenckyStrain<T>& eps) {
  using detail::inverse_factorial;
  const Sym3<T> a = eps.deviator + eps.deviator;
  const detail::TracelessPowers<T> power(a);
  Sym3<T> e;
  if (all(power.j2 <= detail::short_j2)) [[likely]] {
    e = detail::evaluate(detail::power_series<by_precision<T>(8, 4)>(power.j2, power.j3, inverse_factorial), a, power.a2);
  } else {
    e = detail::evaluate(detail::power_series<by_precision<T>(12, 6)>(power.j2, power.j3, inverse_factorial), a, power.a2);
    const Mask<T> inside = power.j2 <= detail::long_j2;
    if (!all(inside)) detail::replace_lanes(inside, a, e, detail::exp_minus_identity_by_eigenvalues);
  }
  const T volume = expm1(eps.volumetric * (2.0 / 3.0));
  e = (1.0 + volume) * e;
  e.xx += volume, e.yy += volume, e.zz += volume;
  return e;
}

/// eps = 1/2 log(I + D), relative precision for small D. A lane where I + D is not positive definite has NaN in tr eps or in the deviator.
/// Coded: with t = 1/3 tr D and A = dev D / (1 + t), eps = 1/2 log(1 + t) I + 1/2 log(I + A); the last by its power series in
/// Cayley-Hamilton form. Truncation relative to A: 3e-15 at order 11 and radius 0.06, 9e-16 at order 26 and radius 0.3; in single precision
/// 1.3e-7 at order 5, 4e-8 at order 12; beyond by eigenvalues.
template <LaneNumber T>
inline __attribute__((always_inline)) HenckyStrain<T> half_log_identity_plus(const Sym3<T>& d) {
  constexpr auto coefficient = [](int k) { return (k % 2 == 1 ? 0.5 : -0.5) / k; };
  const T t = trace(d) * (1.0 / 3.0), scale = 1.0 / (1.0 + t);
  const Sym3<T> a = scale * Sym3<T>{d.xx - t, d.yy - t, d.zz - t, d.xy, d.xz, d.yz};
  const detail::TracelessPowers<T> power(a);
  Sym3<T> e;
  if (all(power.j2 <= detail::short_j2)) [[likely]] {
    e = detail::evaluate(detail::power_series<by_precision<T>(11, 5)>(power.j2, power.j3, coefficient), a, power.a2);
  } else {
    e = detail::evaluate(detail::power_series<by_precision<T>(26, 12)>(power.j2, power.j3, coefficient), a, power.a2);
    const Mask<T> inside = power.j2 <= detail::long_j2;
    if (!all(inside)) detail::replace_lanes(inside, a, e, detail::half_log_identity_plus_by_eigenvalues);
  }
  const T tr = trace(e), mean = tr * (1.0 / 3.0);
  return {1.5 * log1p(t) + tr, {e.xx - mean, e.yy - mean, e.zz - mean, e.xy, e.xz, e.yz}};
}

/// Trial elastic strain: eps_tr = 1/2 log(f b_e f^T) with f = I + dl and b_e = exp(2 eps).
/// Coded with the differences from the identity only: B = b_e - I, P = dl + dl B, f b_e f^T - I = B + P + P^T + P dl^T.
/// NaN in a lane where det f <= 0 (an inverted point; b_e alone would not show it).
/// @param dl  dt * velocity gradient, dimensionless
template <LaneNumber T>
inline __attribute__((always_inline)) HenckyStrain<T> hencky_trial(const HenckyStrain<T>& eps, const Matrix3<T>& dl) {
  const Sym3<T> b = exp_minus_identity(eps);
  const auto& l = dl.m;
  T p[3][3];
  for (int i = 0; i < 3; ++i) {
    p[i][0] = l[i][0] + l[i][0] * b.xx + l[i][1] * b.xy + l[i][2] * b.xz;
    p[i][1] = l[i][1] + l[i][0] * b.xy + l[i][1] * b.yy + l[i][2] * b.yz;
    p[i][2] = l[i][2] + l[i][0] * b.xz + l[i][1] * b.yz + l[i][2] * b.zz;
  }
  const auto difference = [&](const T& start, int i, int j) {
    return start + (p[i][j] + p[j][i]) + p[i][0] * l[j][0] + p[i][1] * l[j][1] + p[i][2] * l[j][2];
  };
  HenckyStrain<T> trial = half_log_identity_plus<T>({difference(b.xx, 0, 0), difference(b.yy, 1, 1), difference(b.zz, 2, 2),
                                                     difference(b.xy, 0, 1), difference(b.xz, 0, 2), difference(b.yz, 1, 2)});
  T size2 = T{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) size2 += l[i][j] * l[i][j];
  if (!all(size2 < 1.0)) {  // |dl| < 1 cannot invert
    const T xx = 1.0 + l[0][0], yy = 1.0 + l[1][1], zz = 1.0 + l[2][2];
    const T det =
        xx * (yy * zz - l[1][2] * l[2][1]) - l[0][1] * (l[1][0] * zz - l[1][2] * l[2][0]) + l[0][2] * (l[1][0] * l[2][1] - yy * l[2][0]);
    const T invalid = select(det > 0.0, T{}, broadcast<T>(std::numeric_limits<double>::quiet_NaN()));
    trial.volumetric += invalid;
    trial.deviator.xx += invalid, trial.deviator.yy += invalid, trial.deviator.zz += invalid;
    trial.deviator.xy += invalid, trial.deviator.xz += invalid, trial.deviator.yz += invalid;
  }
  return trial;
}

}  // namespace mpm
