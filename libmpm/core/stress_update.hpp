#pragma once
/// Constitutive update of one block's particles: sixteen at a time, or 32 in single precision; half as many without AVX-512.

#include "libmpm/core/grid.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {

/// tau and the internal variable at t_n+1 from the velocity gradient C_p that grid_to_particle has set.
/// @returns false if C, stress or internal variable of a particle is not finite: laws give NaN if it is turned inside out (hencky_trial)
bool update_stress(Grid& grid, std::int32_t block, const AnyMaterial& material, double dt);

/// J = det F of one particle.
double volume_ratio(const AnyMaterial& material, const Particle& p);
/// Elastic energy of one particle, J.
double stored_energy(const AnyMaterial& material, const Particle& p);

}  // namespace mpm
