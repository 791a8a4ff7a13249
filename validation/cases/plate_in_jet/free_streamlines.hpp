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

 private:
  double beta_;
};

}  // namespace mpm::validation
