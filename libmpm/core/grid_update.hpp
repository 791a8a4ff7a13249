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
  std::span<const Boundary> boundaries;  ///< in the order in which they act, each on the velocity that the one before left
  std::span<const std::size_t> layered;  ///< numbers of the boundaries whose impulses are booked by grid layer, too
  Vec3 gravity = Vec3::Zero();           ///< m/s^2
  MirrorPlanes mirror;                   ///< whose images are made anew after the boundaries have acted
  double density = 0.0;                  ///< of the material at rest, kg/m^3: with `relaxed`, for the correction around obstacles
  double relaxed = 0.0;                  ///< share of the particles' own motion that relaxes to the grid's in this step
};

/// What one update did; with mirror planes: to the computed part.
struct GridUpdate {
  double mass = 0.0;                  ///< on the grid, kg: gravity gave it the momentum dt g m
  std::vector<Impulse> impulses;      ///< that each boundary took. A node that several boundaries share is booked by each with its own part
  std::vector<LayerImpulses> layers;  ///< of the boundaries in GridForces::layered, in that order
};

/// v_i = p_i / m_i + dt g, then the boundaries in their order; around solids that act at their surface with the correction of
/// lumped_mass.hpp, if the grid keeps its old nodes. Nodes hold velocities afterwards. Each boundary records the change of momentum that it
/// causes; the impulses sum to the total change. Sums over blocks are exact (block_sums.hpp), so that their order and the number of ranks
/// do not matter.
/// @param dt  s. @param time  at the start of the step, s: where travelling boundaries are
GridUpdate update_grid(Grid& grid, const GridForces& forces, double dt, double time);

}  // namespace mpm
