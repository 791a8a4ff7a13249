#include "mpm/materials/drucker_prager.hpp"

#include <fmt/format.h>

#include <numbers>

#include "mpm/error.hpp"

namespace mpm {

namespace {

struct Cone {
  double slope, intercept, dilatancy_slope;  // A, C, A_psi
};

Cone match(ConeMatching matching, double phi, double cohesion, double psi) {
  using std::cos, std::sin, std::sqrt, std::tan;
  switch (matching) {
    case ConeMatching::triaxial_compression: {
      const double d = 3.0 - sin(phi);
      return {6.0 * sin(phi) / d, 6.0 * cohesion * cos(phi) / d, 6.0 * sin(psi) / (3.0 - sin(psi))};
    }
    case ConeMatching::plane_strain: {
      const double a_psi = 3.0 * sin(psi) / sqrt(3.0 + sin(psi) * sin(psi));
      const double d = sqrt((1.0 - a_psi * a_psi / 9.0) / 3.0) + a_psi * sin(phi) / 9.0;
      return {sin(phi) / d, cohesion * cos(phi) / d, a_psi};
    }
    case ConeMatching::simple_shear: break;
  }
  constexpr double sqrt3 = std::numbers::sqrt3;
  return {sqrt3 * tan(phi), sqrt3 * cohesion, sqrt3 * tan(psi)};
}

[[noreturn]] void refuse(std::string_view key, double value, std::string_view remedy) {
  throw ConfigError(fmt::format("[material] {} = {}: {}", key, value, remedy));
}

}  // namespace

DruckerPrager::DruckerPrager(const MaterialSpec& spec) : moduli_(spec) {
  constexpr double degree = std::numbers::pi / 180.0, right_angle = std::numbers::pi / 2.0;
  const double phi = spec.friction_angle, psi = spec.dilatancy_angle;
  if (!(phi > 0.0 && phi < right_angle)) refuse("friction_angle_deg", phi / degree, "a value between 0 and 90 (both excluded) is needed");
  if (!(psi >= 0.0 && psi <= phi)) refuse("dilatancy_angle_deg", psi / degree, "a value from 0 to friction_angle_deg is needed");
  if (!(std::isfinite(spec.cohesion) && spec.cohesion >= 0.0))
    refuse("cohesion_pa", spec.cohesion, "a finite value of at least 0 is needed");
  const Cone cone = match(spec.cone_matching, phi, spec.cohesion, psi);
  slope_ = cone.slope, intercept_ = cone.intercept, dilatancy_slope_ = cone.dilatancy_slope;
  apex_strain_ = intercept_ / (slope_ * moduli_.bulk());
  return_share_ = 1.0 / (1.0 + moduli_.bulk() * slope_ * dilatancy_slope_ / (3.0 * moduli_.shear()));

  const int rate_parameters = int{spec.limit_friction_angle.has_value()} + int{spec.reference_inertial_number.has_value()} +
                              int{spec.grain_diameter.has_value()} + int{spec.grain_density.has_value()};
  if (rate_parameters == 0) return;
  if (rate_parameters < 4)
    throw ConfigError(
        "[material] limit_friction_angle_deg, reference_inertial_number, grain_diameter_m, grain_density_kg_m3: rate dependence needs all "
        "four");
  if (psi > 0.0) refuse("dilatancy_angle_deg", psi / degree, "rate-dependent flow keeps the volume, leave it out");
  const double limit = *spec.limit_friction_angle;
  if (!(limit >= phi && limit < right_angle))
    refuse("limit_friction_angle_deg", limit / degree, "a value from friction_angle_deg up to 90 (excluded) is needed");
  const auto positive = [](std::string_view key, double value) {
    if (!(std::isfinite(value) && value > 0.0)) refuse(key, value, "a finite value above 0 is needed");
    return value;
  };
  reference_inertial_number_ = positive("reference_inertial_number", *spec.reference_inertial_number);
  slope_increase_ = match(spec.cone_matching, limit, 0.0, 0.0).slope - slope_;
  hindrance_ = reference_inertial_number_ * 3.0 * moduli_.shear() /
               (std::sqrt(3.0 * positive("grain_density_kg_m3", *spec.grain_density)) * positive("grain_diameter_m", *spec.grain_diameter));
}

double DruckerPrager::friction_slope_at(double inertial_number) const {
  return hindrance_ > 0.0 ? slope_ + slope_increase_ * inertial_number / (reference_inertial_number_ + inertial_number) : slope_;
}

double DruckerPrager::yield_function(const MaterialState<double>& state) const {
  const double strength = -slope_ * trace(state.stress) / 3.0 + intercept_, q = std::sqrt(1.5 * norm2(deviator(state.stress)));
  return (q - strength) * (q + std::fabs(strength));
}

}  // namespace mpm
