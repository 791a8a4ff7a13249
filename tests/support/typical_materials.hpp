#pragma once
/// A typical material of every law, with every parameter given: one entry a law, two where parameters exclude each other.

#include <vector>

#include "libmpm/material/any_material.hpp"

namespace mpm::testing {

inline std::vector<MaterialParameters> typical_materials() {
  CamClay::Parameters cohesive;
  cohesive.critical_state_slope = 0.8;
  cohesive.cohesion_beta = 0.3;
  DruckerPrager::Parameters sand;
  sand.cohesion = 500.0;
  sand.dilatancy_angle = 0.2;
  DruckerPrager::Parameters rate_dependent_sand;
  rate_dependent_sand.limit_friction_angle = 0.6;
  rate_dependent_sand.reference_inertial_number = 0.279;
  rate_dependent_sand.grain_diameter = 0.53e-3;
  rate_dependent_sand.grain_density = 2450.0;
  return {cohesive, HenckyElastic::Parameters{}, sand, rate_dependent_sand, WeaklyCompressibleFluid::Parameters{}};
}

}  // namespace mpm::testing
