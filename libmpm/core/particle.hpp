#pragma once
/// One material point: everything the step reads and writes, in three cache lines.
///
/// The stress is stored, not b_e: for every law here the elastic Hencky strain is a linear function of the
/// Kirchhoff stress, so that particle_to_grid needs no material and the stored numbers keep full relative
/// precision however small the strain is (b_e would lose it in 1 + 2 eps).

#include <cstdint>
#include <type_traits>

#include "libmpm/base/types.hpp"

namespace mpm {

/// Layout is relied on by particle_groups.hpp and stress_update.cpp (offsets in doubles):
///   0 position(3) volume | 4 velocity(3) id | 8 affine(9) | 17 stress(6) | 23 internal
/// so that each cache line is one 8-lane load, and the vectors are 4-lane loads.
struct alignas(64) Particle {
  double position[3];  ///< m
  double volume;       ///< reference (initial) volume V_0, m^3; mass = rho_0 V_0
  double velocity[3];  ///< m/s
  std::uint64_t id;    ///< identity number, unique in a run, never reused; below 2^52
  double affine[9];    ///< velocity gradient C, 1/s, by columns: affine[3 j + i] = dv_i/dx_j
  double stress[6];    ///< Kirchhoff stress tau, Pa, tension positive: xx yy zz xy xz yz
  double internal;     ///< the law's internal variable (cam_clay: X = -eps_v^P, dimensionless)
};

static_assert(sizeof(Particle) == 192 && std::is_trivially_copyable_v<Particle>);

/// x, m.
inline Vec3 position_of(const Particle& p) { return {p.position[0], p.position[1], p.position[2]}; }
/// v, m/s.
inline Vec3 velocity_of(const Particle& p) { return {p.velocity[0], p.velocity[1], p.velocity[2]}; }

}  // namespace mpm
