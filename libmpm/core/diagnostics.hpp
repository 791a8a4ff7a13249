#pragma once
/// Sums over all particles: mass, momentum, angular momentum, energy.

#include "libmpm/core/state.hpp"

namespace mpm {

/// Sums over the computed part, in the coordinates of the case (without Scene::offset); whole_of_mirrored() adds the images.
struct Totals {
  std::uint64_t particles = 0;           ///< number of particles
  double mass = 0.0;                     ///< kg
  Vec3 centre = Vec3::Zero();            ///< of mass, m; zero without particles
  Vec3 momentum = Vec3::Zero();          ///< kg m/s
  double momentum_scale = 0.0;           ///< sum m |v|, kg m/s: scale for the round-off of the momentum
  Vec3 angular_momentum = Vec3::Zero();  ///< about the origin, kg m^2/s, with the affine part of APIC: x_p x m v_p + m dx^2/4 axial(C_p)
  double angular_momentum_scale = 0.0;   ///< sum m |x||v|, kg m^2/s
  double kinetic_energy = 0.0;           ///< of the particle velocities, J
  double affine_energy = 0.0;  ///< kinetic, of the affine part of APIC, sum m dx^2/8 |C_p|^2 (Jiang et al. 2015), J; 0 with other transfers
  double elastic_energy = 0.0;    ///< J
  double potential_energy = 0.0;  ///< -m g.x, zero at the origin, J
};

/// Kinetic energy, with the affine part that APIC keeps, and elastic energy of one particle, J.
double kinetic_and_elastic_energy(const Particle& p, const Scene& scene, double cell_size);

/// All ranks call it together (CoreTask::totals). Sums are exact (block_sums.hpp): any number of threads and ranks gives the same bits.
Totals totals(const State& state, const Scene& scene);

/// Sums over the whole symmetric domain, from those over the part that is computed.
Totals whole_of_mirrored(Totals part, const MirrorPlanes& mirror);
/// The force on a symmetric body, from the force on its computed part: doubled along the mirror plane, zero across it.
Vec3 whole_force(const Vec3& part, const MirrorPlanes& mirror);
/// The same for a moment (an axial vector).
Vec3 whole_moment(const Vec3& part, const MirrorPlanes& mirror);

}  // namespace mpm
