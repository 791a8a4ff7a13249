#pragma once
/// The grid's part of a step: velocities from momenta, gravity, boundaries.

#include <cstddef>
#include <span>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/core/boundary_impulses.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// What the grid meets during one step.
struct GridConditions {
  std::span<const Boundary> boundaries;  ///< in the order in which they act; each changes the velocity after the previous one
  std::span<const std::size_t> layered;  ///< indices of the boundaries whose impulses are also recorded by grid layer
  Vec3 gravity = Vec3::Zero();           ///< m/s^2
  MirrorPlanes mirror;                   ///< their images are renewed after the boundaries have acted
  double density = 0.0;                  ///< of the material at rest, kg/m^3: for contact at surfaces and the correction around solids
  double relaxed = 0.0;                  ///< 1 - TransferOptions::retained: for that correction
};

/// v_i = p_i / m_i + dt g, then the boundaries in their order; turns Grid::momenta into Grid::velocities. Around solids that act at their
/// surface with the correction of lumped_mass.hpp, if the grid keeps forces apart. Each boundary records the change of momentum that it
/// causes; the impulses sum to the total change.
/// @param dt  s. @param time  at the start of the step, s: where travelling boundaries are
/// @returns what this rank's blocks contribute; it keeps the span conditions.layered
ImpulseRecord update_grid(Grid& grid, const GridConditions& conditions, double dt, double time);

}  // namespace mpm
