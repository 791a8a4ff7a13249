#pragma once
/// Kirchhoff's flow: a plane jet of thickness d and speed U on a plate of width l across its middle, incompressible, without gravity, with
/// free streamlines (p = 0) beside the jet and behind the plate.
///
/// Derivation. With zeta = (u - i v)/U the flow fills the right half of the unit circle: the plate is the diameter zeta = -i tau,
/// -1 <= tau <= 1, every free streamline the arc |zeta| = 1. The jet comes from zeta = 1 and leaves at exp(-+ i beta), beta its angle far
/// away. Source and sinks with their images in the plate give the complex potential
///   W = (U d/pi) (ln(zeta^2 - 1) - 1/2 ln(zeta^4 - 2 zeta^2 cos 2 beta + 1)),
/// and dz = dW/(U zeta) on the plate
///   dy/dtau = (2 d/pi) (1/(1 + tau^2) - (tau^2 + cos 2 beta)/(tau^4 + 2 tau^2 cos 2 beta + 1)),
///   y = (2 d/pi) (atan tau - Re(exp(-i beta) atan(tau exp(-i beta)))).
/// l = 2 y(1) is l/d = 1 - cos beta + (2/pi) sin beta artanh(sin beta), the pressure p = rho U^2/2 (1 - tau^2), and the momentum theorem
/// gives F = rho U^2 d (1 - cos beta). (Kirchhoff 1869; Lamb, Hydrodynamics, Art. 76, for the plate in an endless stream.)
///
/// On the free streamlines zeta = exp(-i sigma), with sigma the direction of the flow, and the integral of dW/(U zeta) is
///   x = (d/pi) (ln tan(sigma/2) - 1/2 cos beta (ln tan((sigma + beta)/2) + ln |tan((sigma - beta)/2)|)) + x_0,
///   y = (d/(2 pi)) sin beta (ln tan((sigma + beta)/2) - ln |tan((sigma - beta)/2)|) + y_0.
/// The edge of the cavity starts at the plate (sigma = pi/2, x = 0, y = l/2) and ends at sigma = beta: x_0 = 0, y_0 = (d/2)(1 - cos beta).
/// The outer edge comes from sigma = 0 at y = d/2. Beyond sigma = beta the logarithm gains i pi: x_0 = -(d/2) sin beta, y_0 = d/2.

#include <cmath>
#include <complex>
#include <numbers>

#include "validation/harness/root.hpp"

namespace mpm::validation {

class PlateInJet {
 public:
  /// @param width_ratio  l/d, above 0 and below 10
  explicit PlateInJet(double width_ratio) {
    const auto excess = [&](double b) {
      return 1.0 - std::cos(b) + 2.0 / std::numbers::pi * std::sin(b) * std::atanh(std::sin(b)) - width_ratio;
    };
    beta_ = root_between(excess, 1e-9, 0.5 * std::numbers::pi - 1e-6);
  }
  /// Angle by which the jet is turned, rad.
  [[nodiscard]] double exit_angle() const { return beta_; }
  /// Force over rho U^2 d.
  [[nodiscard]] double force() const { return 1.0 - std::cos(beta_); }
  /// Place on the plate, over d, where the speed is tau U.
  [[nodiscard]] double place(double tau) const {
    const std::complex<double> turned = std::polar(1.0, -beta_);
    return 2.0 / std::numbers::pi * (std::atan(tau) - (turned * std::atan(tau * turned)).real());
  }
  /// Pressure over rho U^2/2 at y = y_over_d d; 0 beyond the edge.
  [[nodiscard]] double pressure(double y_over_d) const {
    const double y = std::abs(y_over_d);
    if (y >= place(1.0)) return 0.0;
    const double tau = root_between([&](double t) { return place(t) - y; }, 0.0, 1.0);
    return 1.0 - tau * tau;
  }
  /// A point of a free streamline, over d, seen from the middle of the plate.
  struct Point {
    double x, y;
  };
  /// Where the flow has the direction sigma, rad, to the jet: on the edge of the cavity for beta < sigma <= pi/2, on the outer edge for
  /// 0 < sigma < beta.
  [[nodiscard]] Point free_streamline(double sigma) const {
    const double sum = std::log(std::tan(0.5 * (sigma + beta_))), difference = std::log(std::abs(std::tan(0.5 * (sigma - beta_))));
    const double x = (std::log(std::tan(0.5 * sigma)) - 0.5 * std::cos(beta_) * (sum + difference)) / std::numbers::pi;
    const double y = 0.5 * std::sin(beta_) * (sum - difference) / std::numbers::pi;
    if (sigma > beta_) return {x, y + 0.5 * (1.0 - std::cos(beta_))};
    return {x - 0.5 * std::sin(beta_), y + 0.5};
  }
  /// Potential at the same place, over U d: along a free streamline it grows as its length does.
  [[nodiscard]] double potential(double sigma) const {
    const std::complex<double> square = std::polar(1.0, -2.0 * sigma);
    return (std::log(std::abs(square - 1.0)) - 0.5 * std::log(std::abs(square * square - 2.0 * square * std::cos(2.0 * beta_) + 1.0))) /
           std::numbers::pi;
  }

 private:
  double beta_;
};

}  // namespace mpm::validation
