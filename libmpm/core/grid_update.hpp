#pragma once
/// The grid's part of a step: velocities from momenta, gravity, boundaries.

#include <cstddef>
#include <span>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/boundary/impulse.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// What acts on the grid during one step.
struct GridForces {
  std::span<const Boundary> boundaries;  ///< in the order in which they act; each changes the velocity after the previous one
  std::span<const std::size_t> layered;  ///< indices of the boundaries whose impulses are also recorded by grid layer
  Vec3 gravity = Vec3::Zero();           ///< m/s^2
  MirrorPlanes mirror;                   ///< their images are renewed after the boundaries have acted
  double density = 0.0;                  ///< of the material at rest, kg/m^3: with `relaxed`, for the correction around obstacles
  double relaxed = 0.0;                  ///< fraction of the particles' own motion that relaxes to the grid's in this step
};

/// Result of one update; with mirror planes, of the computed part.
struct GridUpdate {
  double mass = 0.0;                  ///< on the grid, kg: its momentum grew by dt g m
  std::vector<Impulse> impulses;      ///< on each boundary. At a node of several boundaries each has its own part
  std::vector<LayerImpulses> layers;  ///< of the boundaries in GridForces::layered, in that order
};

/// v_i = p_i / m_i + dt g, then the boundaries in their order; around solids that act at their surface with the correction of
/// lumped_mass.hpp, if the grid keeps its old nodes. Nodes hold velocities afterwards. Each boundary records the change of momentum that it
/// causes; the impulses sum to the total change. Sums over blocks are exact (block_sums.hpp), so that their order and the number of ranks
/// do not matter.
/// @param dt  s. @param time  at the start of the step, s: where travelling boundaries are
GridUpdate update_grid(Grid& grid, const GridForces& forces, double dt, double time);

}  // namespace mpm
