#include "libmpm/core/grid_update.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace mpm {

namespace {

/// Velocities from momenta, with what gravity adds in dt. Returns the mass of the computed part, kg.
double velocities_of(NodeBlock& nodes, const Index3& block, const MirrorPlanes& mirror, const Node& gained) {
  const bool cut = is_cut(mirror, block);
  double mass = 0.0;
  for (int i = 0; i < block_nodes; ++i) {
    Node& n = nodes.node[i];
    const double m = n[3];
    mass += cut ? computed_share(mirror, block, i) * m : m;
    Node v = n * (m > 0.0 ? 1.0 / m : 0.0) + gained;
    v[3] = m;
    n = v;
  }
  return mass;
}

/// Lets one boundary act on a block's nodes. @param layers  the block's layers of nodes, or null. @returns what the boundary took
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
    const Vec3 taken = (cut ? computed_share(mirror, block, n) : 1.0) * node[3] * (before - after);
    impulse.linear += taken;
    impulse.work -= taken.dot(boundary.surface_velocity(position, time));
    if (layers != nullptr) layers[n / (block_edge * block_edge)] += taken;
    impulse.angular += (position - boundary.reference_point()).cross(taken);
    node = Node{after.x(), after.y(), after.z(), node[3]};
  }
  return impulse;
}

/// Adds what each block booked in its four layers, in the order of the blocks.
LayerImpulses sum_of_layers(const Grid& grid, std::span<const Vec3> partial) {
  constexpr std::int32_t edge = block_edge;
  const auto all = grid.all_blocks();
  const auto took = [&](std::size_t i) {
    return std::any_of(&partial[edge * i], &partial[edge * i] + edge, [](const Vec3& v) { return !v.isZero(0.0); });
  };
  std::int32_t lowest = 0, highest = -1;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!took(i)) continue;
    const std::int32_t z = grid.block(all[i]).coordinate[2];
    if (highest < lowest) lowest = highest = z;
    lowest = std::min(lowest, z);
    highest = std::max(highest, z);
  }
  LayerImpulses sum;
  sum.first = edge * lowest;
  sum.layer.assign(static_cast<std::size_t>(edge * (highest - lowest + 1)), Vec3::Zero());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!took(i)) continue;
    const auto base = static_cast<std::size_t>(edge * (grid.block(all[i]).coordinate[2] - lowest));
    for (std::size_t k = 0; k < edge; ++k) sum.layer[base + k] += partial[edge * i + k];
  }
  return sum;
}

}  // namespace

GridUpdate update_grid(Grid& grid, const GridForces& forces, double dt, double time) {
  const auto all = grid.all_blocks();
  const std::size_t boundaries = forces.boundaries.size(), layered = forces.layered.size(), layers = block_edge * all.size();
  const double dx = grid.cell_size();
  const Node gained = {dt * forces.gravity.x(), dt * forces.gravity.y(), dt * forces.gravity.z(), 0.0};
  std::vector<double> mass(all.size());
  std::vector<Impulse> taken(all.size() * boundaries);               // by block
  std::vector<Vec3> taken_by_layer(layered * layers, Vec3::Zero());  // by boundary, block and layer
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < all.size(); ++i) {
    NodeBlock& nodes = grid.nodes(all[i]);
    const Index3& block = grid.block(all[i]).coordinate;
    mass[i] = velocities_of(nodes, block, forces.mirror, gained);
    const Vec3 low = node_position(block, 0, dx), high = low + Vec3::Constant((block_edge - 1) * dx);
    for (std::size_t b = 0; b < boundaries; ++b) {
      const auto booked = std::ranges::find(forces.layered, b) - forces.layered.begin();
      Vec3* const block_layers =
          booked < std::ssize(forces.layered) ? &taken_by_layer[static_cast<std::size_t>(booked) * layers + block_edge * i] : nullptr;
      std::visit(
          [&](const auto& boundary) {
            if (!boundary.reaches(low, high, time)) return;
            taken[i * boundaries + b] = constrain_block(boundary, nodes, block, forces.mirror, dx, time, block_layers);
          },
          forces.boundaries[b]);
    }
  }
  reflect_velocities(grid, forces.mirror);

  GridUpdate update;
  update.impulses.resize(boundaries);
  for (std::size_t i = 0; i < all.size(); ++i) {
    update.mass += mass[i];
    for (std::size_t b = 0; b < boundaries; ++b) update.impulses[b] += taken[i * boundaries + b];
  }
  for (std::size_t k = 0; k < layered; ++k)
    update.layers.push_back(sum_of_layers(grid, std::span(taken_by_layer).subspan(k * layers, layers)));
  return update;
}

}  // namespace mpm
