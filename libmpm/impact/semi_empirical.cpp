#include "libmpm/impact/semi_empirical.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/base/error.hpp"
#include "libmpm/material/cam_clay.hpp"

namespace mpm {
namespace {

/// Accepts finite values that satisfy `holds`; NaN never does.
void require(bool holds, const char* name, double value, const char* range) {
  if (!holds || !std::isfinite(value)) throw ConfigError(fmt::format("{} = {}: must be {}", name, value, range));
}
void require_positive(const char* name, double value) { require(value > 0.0, name, value, "greater than 0"); }
void require_non_negative(const char* name, double value) { require(value >= 0.0, name, value, "at least 0"); }

}  // namespace

double effective_friction(double critical_state_slope, double cohesion_beta) {
  require_non_negative("critical-state slope M", critical_state_slope);
  require(cohesion_beta >= 0.0 && cohesion_beta < 1.0, "cohesion beta", cohesion_beta, "at least 0 and less than 1");
  CamClay::Parameters snow;
  snow.critical_state_slope = critical_state_slope;
  snow.cohesion_beta = cohesion_beta;
  return snow.critical_state_ratio();
}

double friction_angle(double effective_friction) {
  require(effective_friction >= 0.0 && effective_friction <= 3.0, "effective friction M'", effective_friction,
          "in [0, 3], where a friction angle exists");
  return CamClay::Parameters::friction_angle(effective_friction);
}

double bulk_modulus(double young_modulus, double poisson_ratio) {
  require_positive("Young's modulus", young_modulus);
  require(poisson_ratio > -1.0 && poisson_ratio < 0.5, "Poisson's ratio", poisson_ratio, "greater than -1 and less than 0.5");
  return young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio));
}

double plastic_compressibility(double xi, double pressure, double initial_pressure, double bulk_modulus) {
  require_positive("hardening parameter xi", xi);
  require_non_negative("pre-consolidation pressure p_c", pressure);
  require_non_negative("initial pre-consolidation pressure p_c0", initial_pressure);
  require_positive("bulk modulus", bulk_modulus);
  return std::exp((std::asinh(pressure / bulk_modulus) - std::asinh(initial_pressure / bulk_modulus)) / xi);
}

double froude_number(double velocity, double flow_height, double gravity) {
  require_non_negative("velocity", velocity);
  require_positive("flow height", flow_height);
  require_positive("gravity", gravity);
  return velocity / std::sqrt(gravity * flow_height);
}

double flow_velocity(double froude, double flow_height, double gravity) {
  require_non_negative("Froude number", froude);
  require_positive("flow height", flow_height);
  require_positive("gravity", gravity);
  return froude * std::sqrt(gravity * flow_height);
}

double conveyor_width(double xi, double obstacle_width) {
  require_positive("hardening parameter xi", xi);
  require_positive("obstacle width", obstacle_width);
  const double ratio = 6.0 + 3.0 * std::log10(xi / 0.05);
  require(ratio > 1.0, "hardening parameter xi", xi, "greater than 0.0011: below it W(xi) is narrower than the obstacle; give the width");
  return ratio * obstacle_width;
}

double conveyor_length(double velocity, double duration) {
  require_non_negative("velocity", velocity);
  require_non_negative("duration", duration);
  return velocity * duration + 3.0;
}

double magnification_factor(double effective_friction, const HeightCoefficients& coefficients) {
  require_non_negative("effective friction M'", effective_friction);
  return coefficients.k * effective_friction;
}

double dissipation_factor(double effective_friction, const HeightCoefficients& coefficients) {
  require_non_negative("effective friction M'", effective_friction);
  return std::exp(coefficients.kappa * effective_friction);
}

double predicted_height(double effective_friction, double velocity, double flow_height, const HeightCoefficients& coefficients,
                        double gravity) {
  require_positive("flow height", flow_height);
  const double saturation_head = 0.5 * coefficients.saturation_froude * coefficients.saturation_froude * flow_height;
  const double head = std::min(velocity_head(velocity, gravity), saturation_head);
  return flow_height * (1.0 + magnification_factor(effective_friction, coefficients)) +
         head / dissipation_factor(effective_friction, coefficients);
}

std::vector<std::string> outside_of_equations(double froude, double relative_width, std::optional<double> effective_friction,
                                              std::optional<double> hardening_xi) {
  constexpr double rounding = 1e-9, alike = 0.05;
  std::vector<std::string> outside;
  if (relative_width < 0.5 - rounding || relative_width > 3.0 + rounding) {
    outside.push_back(fmt::format("w/H = {:.3g} (simulated: 0.5 to 3)", relative_width));
  } else if (std::abs(relative_width - 1.0) > alike) {
    outside.push_back(
        fmt::format("w/H = {:.3g} (fitted: 1; the width changes run-up little and pressure height more, Sect. 4.3)", relative_width));
  }
  if (froude < 0.1 - rounding || froude > 7.0 + rounding) outside.push_back(fmt::format("Fr = {:.3g} (0.1 to 7)", froude));
  if (effective_friction && *effective_friction > 2.3) outside.push_back(fmt::format("M' = {:.3g} (0 to 2.3)", *effective_friction));
  if (hardening_xi && (*hardening_xi < 0.15 || *hardening_xi > 15.0))
    outside.push_back(fmt::format("xi = {:.3g} (fitted: 0.15 to 15)", *hardening_xi));
  return outside;
}

double predicted_runup(double effective_friction, double velocity, double flow_height, double gravity) {
  return predicted_height(effective_friction, velocity, flow_height, runup_coefficients, gravity);
}

double predicted_pressure_height(double effective_friction, double velocity, double flow_height, double gravity) {
  return predicted_height(effective_friction, velocity, flow_height, pressure_height_coefficients, gravity);
}

double width_factor(double relative_width) {
  require_positive("relative width w/H", relative_width);
  return -std::expm1(-1.14 * relative_width);
}

double limited_width_factor(double relative_width) { return std::max(width_factor(relative_width), recommended_width_factor_floor); }

double guideline_runup(double velocity, double lambda, double width_factor, double gravity) {
  require(lambda >= 1.0, "energy dissipation factor lambda", lambda, "at least 1");
  require(width_factor > 0.0 && width_factor <= 1.0, "width factor f", width_factor, "greater than 0 and at most 1");
  return velocity_head(velocity, gravity) / lambda * width_factor;
}

double velocity_head(double velocity, double gravity) {
  require_non_negative("velocity", velocity);
  require_positive("gravity", gravity);
  return velocity * velocity / (2.0 * gravity);
}

double bernoulli_height(double velocity, double flow_height, double gravity) {
  require_positive("flow height", flow_height);
  return flow_height + velocity_head(velocity, gravity);
}

double hencky_stagnation_pressure(double velocity, double density, double bulk_modulus) {
  require_non_negative("velocity", velocity);
  require_positive("density", density);
  require_positive("bulk modulus", bulk_modulus);
  const double s = density * velocity * velocity / bulk_modulus;
  const double x = s / (1.0 + std::sqrt(1.0 + s));  // -1 + sqrt(1 + s) without cancellation
  return bulk_modulus * x * std::exp(x);
}

}  // namespace mpm
