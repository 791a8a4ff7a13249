#pragma once
/// The list of laws. To add one: write its header against the concept `Material`, add it to this variant, add an entry to the table in
/// tests/unit/test_materials.cpp. Nothing else names the laws.

#include <string>
#include <variant>
#include <vector>

#include "mpm/materials/cam_clay.hpp"
#include "mpm/materials/drucker_prager.hpp"
#include "mpm/materials/hencky_elastic.hpp"
#include "mpm/materials/weakly_compressible_fluid.hpp"

namespace mpm {

using AnyMaterial = std::variant<HenckyElastic, CamClay, DruckerPrager, WeaklyCompressibleFluid>;

/// The law whose `name` is spec.model. ConfigError if there is none (the message lists the known ones) or if the law refuses its
/// parameters.
AnyMaterial make_material(const MaterialSpec& spec);

double density_of(const AnyMaterial& material);           ///< rho_0, kg/m^3
double wave_speed_of(const AnyMaterial& material);        ///< of the fastest elastic wave, m/s
double initial_internal_of(const AnyMaterial& material);  ///< of a stress-free point
double viscosity_of(const AnyMaterial& material);         ///< eta, Pa s; 0 for a law without viscous stress
/// J = det F
double volume_ratio(const AnyMaterial& material, const MaterialState<double>& state);

/// The names of all laws, in the order of the variant.
std::vector<std::string> material_names();

}  // namespace mpm
