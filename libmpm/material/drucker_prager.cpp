#include "libmpm/material/drucker_prager.hpp"

#include <numbers>

#include "libmpm/base/parameter.hpp"

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

}  // namespace

void DruckerPrager::Parameters::check(ParameterReport& report) const {
  if (report.all_valid({"dilatancy_angle_deg", "friction_angle_deg"}) && dilatancy_angle > friction_angle)
    report.problem("dilatancy_angle_deg", "is above friction_angle_deg, which would create energy; give at most that");
  if (limit_friction_angle && report.all_valid({"limit_friction_angle_deg", "friction_angle_deg"}) &&
      *limit_friction_angle < friction_angle)
    report.problem("limit_friction_angle_deg", "is below friction_angle_deg; friction grows with the rate, give at least that");

  const std::pair<std::string, bool> rate_parameters[] = {{"limit_friction_angle_deg", limit_friction_angle.has_value()},
                                                          {"reference_inertial_number", reference_inertial_number.has_value()},
                                                          {"grain_diameter_m", grain_diameter.has_value()},
                                                          {"grain_density_kg_m3", grain_density.has_value()}};
  const auto there = std::find_if(std::begin(rate_parameters), std::end(rate_parameters), [](const auto& p) { return p.second; });
  if (there == std::end(rate_parameters)) return;
  for (const auto& [key, has_value] : rate_parameters) {
    if (!has_value && report.valid(key))
      report.problem(key, "is missing beside " + there->first + "; rate dependence needs all four of its keys");
  }
  if (dilatancy_angle > 0.0 && report.valid("dilatancy_angle_deg"))
    report.problem("dilatancy_angle_deg", "is given beside " + there->first + "; rate-dependent flow keeps the volume, leave it out");
}

DruckerPrager::DruckerPrager(const Parameters& p) : moduli_(checked(p)) {
  const Cone cone = match(p.cone_matching, p.friction_angle, p.cohesion, p.dilatancy_angle);
  slope_ = cone.slope, intercept_ = cone.intercept, dilatancy_slope_ = cone.dilatancy_slope;
  apex_strain_ = intercept_ / (slope_ * moduli_.bulk());
  return_factor_ = 1.0 / (1.0 + moduli_.bulk() * slope_ * dilatancy_slope_ / (3.0 * moduli_.shear()));
  if (!p.limit_friction_angle) return;
  reference_inertial_number_ = *p.reference_inertial_number;
  slope_increase_ = match(p.cone_matching, *p.limit_friction_angle, 0.0, 0.0).slope - slope_;
  hindrance_ = reference_inertial_number_ * 3.0 * moduli_.shear() / (std::sqrt(3.0 * *p.grain_density) * *p.grain_diameter);
}

double DruckerPrager::friction_slope_at(double inertial_number) const {
  return hindrance_ > 0.0 ? slope_ + slope_increase_ * inertial_number / (reference_inertial_number_ + inertial_number) : slope_;
}

double DruckerPrager::yield_function(const MaterialState<double>& state) const {
  const double strength = -slope_ * trace(state.stress) / 3.0 + intercept_, q = std::sqrt(1.5 * norm2(deviator(state.stress)));
  return (q - strength) * (q + std::fabs(strength));
}

}  // namespace mpm
