#include "libmpm/core/grid_update.hpp"

#include <algorithm>
#include <map>
#include <type_traits>
#include <vector>

#include "libmpm/core/folded_terrain.hpp"
#include "libmpm/core/folded_wall.hpp"
#include "libmpm/core/lumped_mass.hpp"
#include "libmpm/core/surface_contact.hpp"

namespace mpm {

namespace {

/// Velocities from momenta, with the change by gravity. Returns the mass of the computed part, kg.
/// @param forces  null, or momenta of internal forces that are kept apart; gets the velocities before forces. @param gravity  {dt g, 0}
double velocities_of(NodeBlock& nodes, NodeBlock* forces, const Index3& block, const MirrorPlanes& mirror, const Node& gravity) {
  const bool cut = is_cut(mirror, block);
  double mass = 0.0;
  for (int i = 0; i < block_nodes; ++i) {
    Node& n = nodes.node[i];
    const double m = n[3];
    mass += cut ? computed_fraction(mirror, block, i) * m : m;
    const double inverse = m > 0.0 ? 1.0 / m : 0.0;
    Node v = n * inverse;
    if (forces != nullptr) {
      const Node impulse = forces->node[i];
      forces->node[i] = v;
      v += impulse * inverse;
    }
    v += gravity;
    v[3] = m;
    n = v;
  }
  return mass;
}

/// Lets one boundary act on a block's nodes. @param layers  the block's layers of nodes, or null. @returns the impulse on the boundary
template <class AnyOf>
Impulse constrain_block(const AnyOf& boundary, NodeBlock& nodes, const Index3& block, const MirrorPlanes& mirror, double dx, double time,
                        Vec3* layers) {
  Impulse impulse;
  const bool cut = is_cut(mirror, block);
  for (int n = 0; n < block_nodes; ++n) {
    Node& node = nodes.node[n];
    if (node[3] <= 0.0) continue;
    const Vec3 position = node_position(block, n, dx);
    if (!boundary.covers(position, time)) continue;
    const Vec3 before(node[0], node[1], node[2]);
    const Vec3 after = boundary.constrain(position, before, time);
    const Vec3 taken = (cut ? computed_fraction(mirror, block, n) : 1.0) * node[3] * (before - after);
    impulse.add(taken, position - boundary.reference_point(), boundary.surface_velocity(position, time));
    if (layers != nullptr) layers[place_along(2, n)] += taken;
    node = Node{after.x(), after.y(), after.z(), node[3]};
  }
  return impulse;
}

/// Applies a scene's boundaries, one after another, and records the impulse on each.
class BoundaryActions {
 public:
  /// @param blocks  of Grid::own_blocks(), all or some, on which the boundaries act; solids with contact at their surface act on all
  BoundaryActions(Grid& grid, const GridConditions& conditions, double dt, double time, std::span<const std::int32_t> blocks)
      : grid_(grid),
        conditions_(conditions),
        dt_(dt),
        time_(time),
        blocks_(blocks),
        layers_(block_edge * blocks.size()),
        taken_(blocks.size() * conditions.boundaries.size()),
        by_layer_(conditions.layered.size() * layers_, Vec3::Zero()) {}

  /// The end of the run of boundaries from `first` on that act on each node by itself.
  [[nodiscard]] std::size_t end_of_nodal(std::size_t first) const {
    std::size_t b = first;
    while (b < conditions_.boundaries.size() && nodal(b)) ++b;
    return b;
  }

  /// Lets boundaries first .. last - 1 act on the nodes of the i-th block.
  void act_on_block(std::size_t i, std::size_t first, std::size_t last) {
    const std::int32_t index = blocks_[i];
    NodeBlock& nodes = grid_.velocities(index);
    const Index3& block = grid_.block(index).coordinate;
    const double dx = grid_.cell_size();
    const Vec3 low = node_position(block, 0, dx), high = low + Vec3::Constant((block_edge - 1) * dx);
    for (std::size_t b = first; b < last; ++b) {
      const std::size_t k = layered_index(b);
      Vec3* const layers = k < conditions_.layered.size() ? &by_layer_[k * layers_ + block_edge * i] : nullptr;
      std::visit(
          [&](const auto& boundary) {
            if constexpr (HasConstrain<std::decay_t<decltype(boundary)>>) {
              if (boundary.reaches(low, high, time_))
                taken_[i * conditions_.boundaries.size() + b] =
                    constrain_block(boundary, nodes, block, conditions_.mirror, dx, time_, layers);
            }
          },
          conditions_.boundaries[b]);
    }
  }

  /// Lets boundary b act, which acts on several nodes together.
  void act(std::size_t b) {
    const Boundary& boundary = conditions_.boundaries[b];
    if (const auto* solid = std::get_if<SurfaceSolid>(&boundary)) {
      ContactImpulse& impulse = contacts_[b] = apply_surface_contact(grid_, *solid, conditions_.density, conditions_.gravity.z(), dt_);
      apply_folded_faces(grid_, *solid, conditions_.mirror, conditions_.density, dt_, impulse);
    } else {
      const auto* const terrain = std::get_if<Terrain>(&boundary);
      const auto by_block = terrain != nullptr ? apply_folded_terrain(grid_, *terrain, conditions_.mirror, blocks_)
                                               : apply_folded_wall(grid_, std::get<Wall>(boundary), conditions_.mirror, time_, blocks_);
      for (std::size_t i = 0; i < by_block.size(); ++i) taken_[i * conditions_.boundaries.size() + b] = by_block[i];
    }
  }

  /// Lets boundaries first, first + 1, ... to the last act, in turn.
  void act_from(std::size_t first) {
    while (first < conditions_.boundaries.size()) {
      const std::size_t joint = end_of_nodal(first);
      if (joint > first) {
#pragma omp parallel for schedule(static, 8)
        for (std::size_t i = 0; i < blocks_.size(); ++i) act_on_block(i, first, joint);
      }
      if (joint < conditions_.boundaries.size()) act(joint);
      first = joint + 1;
    }
  }

  /// What was recorded. @param mass  of each block
  ImpulseRecord result(std::span<const double> mass) && {
    const std::size_t count = conditions_.boundaries.size();
    ImpulseRecord record(count, conditions_.layered);
    for (const double m : mass) record.add_mass(m);
    for (std::size_t n = 0; n < taken_.size(); ++n) record.add_impulse(n % count, taken_[n]);
    for (std::size_t k = 0; k < conditions_.layered.size(); ++k) {
      if (!nodal(conditions_.layered[k])) continue;
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const std::span<const Vec3, block_edge> layers(&by_layer_[k * layers_ + block_edge * i], std::size_t{block_edge});
        record.add_layers(k, grid_.block(blocks_[i]).coordinate, layers);
      }
    }
    for (auto& [b, impulse] : contacts_) record.add_contact(b, std::move(impulse));
    return record;
  }

 private:
  [[nodiscard]] bool nodal(std::size_t b) const {
    const Boundary& boundary = conditions_.boundaries[b];
    if (const auto* const terrain = std::get_if<Terrain>(&boundary)) return terrain->rule == ContactRule::nodal;
    const auto* const wall = std::get_if<Wall>(&boundary);
    return !std::holds_alternative<SurfaceSolid>(boundary) &&
           (wall == nullptr || !folds(*wall, conditions_.boundaries, conditions_.mirror, grid_.cell_size(), time_));
  }
  /// Index of a boundary among those whose impulses are recorded by layer; past the end for the others.
  [[nodiscard]] std::size_t layered_index(std::size_t b) const {
    return static_cast<std::size_t>(std::ranges::find(conditions_.layered, b) - conditions_.layered.begin());
  }

  Grid& grid_;
  const GridConditions& conditions_;
  double dt_, time_;
  std::span<const std::int32_t> blocks_;
  std::size_t layers_;                              ///< of nodes, in these blocks
  std::vector<Impulse> taken_;                      ///< by block and boundary, of all but solids that act at their surface
  std::vector<Vec3> by_layer_;                      ///< by boundary, block and layer, of the nodal ones
  std::map<std::size_t, ContactImpulse> contacts_;  ///< by boundary, of solids that act at their surface
};

}  // namespace

ImpulseRecord update_grid(Grid& grid, const GridConditions& conditions, double dt, double time) {
  const auto blocks = grid.own_blocks();
  const Node gravity = {dt * conditions.gravity.x(), dt * conditions.gravity.y(), dt * conditions.gravity.z(), 0.0};
  std::vector<double> mass(blocks.size());
  BoundaryActions boundaries(grid, conditions, dt, time, blocks);
  const bool corrected = grid.keeps_forces_apart() && need_lumped_mass_correction(conditions.boundaries);
  const std::size_t next = corrected ? 0 : boundaries.end_of_nodal(0);  // the first that acts after all velocities are known
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    NodeBlock* const internal = grid.keeps_forces_apart() ? &grid.force_impulses(blocks[i]) : nullptr;
    mass[i] = velocities_of(grid.momenta(blocks[i]), internal, grid.block(blocks[i]).coordinate, conditions.mirror, gravity);
    boundaries.act_on_block(i, 0, next);
  }
  if (corrected) {
    // Around a solid all boundaries act twice: on trial, because the accelerations to be corrected are those with contact, and then on the
    // corrected velocities. The impulses of the trial are not recorded.
    correct_lumped_mass(grid, conditions.boundaries, conditions.density, conditions.relaxed, conditions.mirror,
                        [&](std::span<const std::int32_t> near) { BoundaryActions(grid, conditions, dt, time, near).act_from(0); });
  }
  boundaries.act_from(next);
  reflect_velocities(grid, conditions.mirror, blocks);

  return std::move(boundaries).result(mass);
}

}  // namespace mpm
