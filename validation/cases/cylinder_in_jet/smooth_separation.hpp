#pragma once
/// A plane jet of thickness d and speed U on a circular cylinder across its middle, incompressible, without gravity, with free streamlines
/// (p = 0) beside the jet and behind the cylinder. The streamlines leave the cylinder where the pressure reaches zero with a finite
/// curvature (Brillouin 1911; Villat 1914), as a fluid that carries no tension does.
///
/// Derivation (after Levi-Civita 1907). Upper half, h = d/2 = 1, U = 1. The complex potential W fills the strip 0 < psi < 1, and t = exp(pi
/// W) maps it onto the upper half plane: t < 0 is the outer free streamline, 0 < t < 1 the axis before the stagnation point t = 1, 1 < t <
/// c the wetted arc, t > c the free streamline behind it. omega = -ln q + i theta (speed q, direction theta) is analytic there, its real
/// part is 0 for t < 0 and t > c, its imaginary part 0 on the axis and theta(t) on the arc. Divided by sqrt(t (t - c)) this is Cauchy's
/// integral,
///   -ln q(t) = (sqrt(t (c - t))/pi) PV int_1^c theta(s) / (sqrt(s (c - s)) (s - t)) ds      on the arc,
///   theta far away = (1/pi) int_1^c theta(s)/sqrt(s (c - s)) ds.
/// With s = c sin^2 u the integral of a constant theta over a panel is a logarithm. On the circle theta = pi/2 - (arc length)/R, with the
/// arc length int dW/q = int dt/(pi t q): a fixed point for given c. c is where the singularity of omega at t = c vanishes. The momentum
/// theorem gives the force, F = rho U^2 d (1 - cos(theta far away)).
///
/// Checks: for R/h -> 0 the streamlines leave at 55.0 degrees with a drag coefficient of 0.498 (Brodetsky 1923: 55 degrees, 0.4986); with
/// theta = pi/2 the same equations are Kirchhoff's plate.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "validation/harness/norms.hpp"
#include "validation/harness/root.hpp"

namespace mpm::validation {

/// The flow for one ratio of diameter to thickness.
class CylinderInJet {
 public:
  /// @param width_ratio  diameter over d, between 0.01 and 2
  explicit CylinderInJet(double width_ratio) : radius_(width_ratio) {
    double low = 1.0 + 0.2 * radius_;  // the arc is shorter there than that of a smooth separation
    while (excess(1.0 + 1.5 * (low - 1.0)) * excess(low) > 0.0) low = 1.0 + 1.5 * (low - 1.0);
    solve(root_between([&](double c) { return excess(c); }, low, 1.0 + 1.5 * (low - 1.0)));
  }
  /// Angle by which the jet is turned, rad.
  [[nodiscard]] double exit_angle() const { return exit_angle_; }
  /// Force over rho U^2 d.
  [[nodiscard]] double force() const { return 1.0 - std::cos(exit_angle_); }
  /// Angle from the front at which the streamlines leave, rad.
  [[nodiscard]] double separation_angle() const { return separation_angle_; }

 private:
  static constexpr int panels = 200;

  double excess(double c) {
    solve(c);
    return singularity_;
  }

  void solve(double c) {
    using Array = Eigen::ArrayXd;
    const auto place = [&](double fraction) { return 1.0 + 0.5 * (c - 1.0) * (1.0 - std::cos(std::numbers::pi * fraction)); };
    Array edge(panels + 1), u(panels + 1), t(panels), length(panels);  // panels, closer together at both ends
    for (int i = 0; i <= panels; ++i) {
      edge[i] = place(static_cast<double>(i) / panels);
      u[i] = std::asin(std::sqrt(std::min(edge[i] / c, 1.0)));
    }
    for (int i = 0; i < panels; ++i) {
      t[i] = place((i + 0.5) / panels);
      length[i] = 0.5 * (c - 1.0) * std::sin(std::numbers::pi * (i + 0.5) / panels) / panels / t[i];  // dt/(pi t) of the panel
    }
    Eigen::ArrayXXd kernel(panels, panels);
    for (int i = 0; i < panels; ++i) {
      const double v = std::asin(std::sqrt(t[i] / c));
      const auto primitive = [&](double w) {
        return std::log(std::abs(std::sin(w - v) / std::sin(w + v))) / (c * std::sin(v) * std::cos(v));
      };
      const double factor = std::sqrt(t[i] * (c - t[i])) / std::numbers::pi;
      for (int j = 0; j < panels; ++j) kernel(i, j) = factor * (primitive(u[j + 1]) - primitive(u[j]));
    }
    Array theta = Array::Constant(panels, 0.5 * std::numbers::pi);
    double arc = 0.0;
    for (int iteration = 0; iteration < 400; ++iteration) {
      Array slowness = Array::Zero(panels);  // 1/q
      for (int j = 0; j < panels; ++j) slowness += theta[j] * kernel.col(j);
      slowness = slowness.exp();
      arc = 0.0;
      Array next(panels);
      double change = 0.0;
      for (int i = 0; i < panels; ++i) {
        const double step = length[i] * slowness[i];
        next[i] = 0.5 * std::numbers::pi - (arc + 0.5 * step) / radius_;
        arc += step;
        change = larger(change, std::abs(next[i] - theta[i]));
      }
      theta = 0.5 * (theta + next);
      if (change < 1e-12) break;
    }
    separation_angle_ = arc / radius_;
    exit_angle_ = (theta * (u.tail(panels) - u.head(panels))).sum() * 2.0 / std::numbers::pi;
    // int theta/(sqrt(s (c - s)) (s - c)) ds; the constant part theta(c) of it is an integral over the axis, with the other sign
    const double slope = (theta[panels - 1] - theta[panels - 2]) / (t[panels - 1] - t[panels - 2]);
    const double end = theta[panels - 1] + slope * (c - t[panels - 1]);
    const auto primitive = [&](double w) { return -2.0 / c * std::tan(w); };
    singularity_ = -end * primitive(u[0]) + 2.0 * slope * (u[panels] - u[panels - 1]);
    for (int i = 0; i + 1 < panels; ++i) singularity_ += (theta[i] - end) * (primitive(u[i + 1]) - primitive(u[i]));
  }

  double radius_;  ///< over h
  double exit_angle_ = 0.0, separation_angle_ = 0.0, singularity_ = 0.0;
};

}  // namespace mpm::validation
