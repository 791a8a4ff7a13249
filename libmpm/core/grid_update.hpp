#pragma once
/// The grid's part of a step: velocities from momenta, gravity, boundaries.

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/boundary/impulse.hpp"
#include "libmpm/core/block_sums.hpp"
#include "libmpm/core/block_table.hpp"
#include "libmpm/core/mirror.hpp"
#include "libmpm/core/surface_contact.hpp"

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

/// What one rank contributes to a GridUpdate. It is summed later, so that no rank has to wait for the others between its grid and its
/// particles.
class GridUpdatePart {
 public:
  /// @param boundaries  their number. @param layered  GridForces::layered
  GridUpdatePart(std::size_t boundaries, std::span<const std::size_t> layered);

  /// Adds the mass of a block, kg.
  void add_mass(double mass) { sums_.add(0, mass); }
  /// Adds the impulse that boundary b took from the nodes of a block.
  void add_impulse(std::size_t b, const Impulse& taken);
  /// Adds the impulses on the four layers of nodes of a block, of the k-th layered boundary. @param layers  x, y, z of each, N s
  void add_layers(std::size_t k, const Index3& block, std::span<const double> layers) { layers_[k].add_unless_zero(block, layers); }
  /// The impulse on boundary b, which acts on the nodes of many blocks together.
  void add_contact(std::size_t b, ContactImpulse impulse) { contacts_[b] = std::move(impulse); }
  /// Adds what a boundary like that took from particles besides. @param layer  number of the layer of nodes near them
  void add_to_contact(std::size_t b, std::int32_t layer, const Impulse& taken);

  /// The whole, over all ranks; all ranks call it. @param ranks  null: there is only this one. @returns on ranks other than the first
  /// without layers and without the impulses of add_contact()
  GridUpdate sum(Ranks* ranks) &&;

 private:
  void gather_contacts(Ranks& ranks);

  std::span<const std::size_t> layered_;
  std::size_t boundaries_;
  BlockSums sums_;                                  ///< the mass, then the impulse on each boundary
  std::vector<BlockTable> layers_;                  ///< of each layered boundary
  std::map<std::size_t, ContactImpulse> contacts_;  ///< by boundary
};

/// v_i = p_i / m_i + dt g, then the boundaries in their order; around solids that act at their surface with the correction of
/// lumped_mass.hpp, if the grid keeps its old nodes. Nodes hold velocities afterwards. Each boundary records the change of momentum that it
/// causes; the impulses sum to the total change. Sums over blocks are exact (block_sums.hpp), so that their order and the number of ranks
/// do not matter.
/// @param forces  must outlive the result. @param dt  s. @param time  at the start of the step, s: where travelling boundaries are
/// @returns what this rank's blocks contribute
GridUpdatePart update_grid(Grid& grid, const GridForces& forces, double dt, double time);

}  // namespace mpm
