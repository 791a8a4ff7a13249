#include "libmpm/core/grid_update.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <type_traits>

#include "libmpm/core/block_table.hpp"
#include "libmpm/core/folded_wall.hpp"
#include "libmpm/core/surface_contact.hpp"

namespace mpm {

namespace {

/// Velocities from momenta, with what gravity adds in dt. Returns the mass of the computed part, kg.
/// @param old  not null: holds the momentum that internal forces give, and gets the velocities before forces
double velocities_of(NodeBlock& nodes, NodeBlock* old, const Index3& block, const MirrorPlanes& mirror, const Node& gained) {
  const bool cut = is_cut(mirror, block);
  double mass = 0.0;
  for (int i = 0; i < block_nodes; ++i) {
    Node& n = nodes.node[i];
    const double m = n[3];
    mass += cut ? computed_share(mirror, block, i) * m : m;
    const double inverse = m > 0.0 ? 1.0 / m : 0.0;
    Node v = n * inverse;
    if (old != nullptr) {
      const Node forces = old->node[i];
      old->node[i] = v;
      v += forces * inverse;
    }
    v += gained;
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
    impulse.add(taken, position - boundary.reference_point(), boundary.surface_velocity(position, time));
    if (layers != nullptr) layers[n / node_stride(2)] += taken;
    node = Node{after.x(), after.y(), after.z(), node[3]};
  }
  return impulse;
}

/// Adds what each block booked in its four layers, in the order of the blocks. @param blocks  their coordinates
LayerImpulses sum_of_layers(std::span<const Index3> blocks, std::span<const Vec3> partial) {
  constexpr std::int32_t edge = block_edge;
  const auto took = [&](std::size_t i) {
    return std::any_of(&partial[edge * i], &partial[edge * i] + edge, [](const Vec3& v) { return !v.isZero(0.0); });
  };
  std::int32_t lowest = 0, highest = -1;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!took(i)) continue;
    const std::int32_t z = blocks[i][2];
    if (highest < lowest) lowest = highest = z;
    lowest = std::min(lowest, z);
    highest = std::max(highest, z);
  }
  LayerImpulses sum;
  sum.first = edge * lowest;
  sum.layer.assign(static_cast<std::size_t>(edge * (highest - lowest + 1)), Vec3::Zero());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!took(i)) continue;
    const auto base = static_cast<std::size_t>(edge * (blocks[i][2] - lowest));
    for (std::size_t k = 0; k < edge; ++k) sum.layer[base + k] += partial[edge * i + k];
  }
  return sum;
}

constexpr std::size_t impulse_numbers = 7;
static_assert(sizeof(Impulse) == impulse_numbers * sizeof(double) && sizeof(Vec3) == 3 * sizeof(double));

/// Applies a scene's boundaries, one after another, and books what each took.
class Boundaries {
 public:
  Boundaries(Grid& grid, const GridForces& forces, double time)
      : grid_(grid),
        forces_(forces),
        time_(time),
        blocks_(coordinates_of(grid)),
        layers_(block_edge * blocks_.size()),
        taken_(blocks_.size() * forces.boundaries.size()),
        by_layer_(forces.layered.size() * layers_, Vec3::Zero()) {
    update_.impulses.resize(forces.boundaries.size());
    update_.layers.resize(forces.layered.size());
  }

  /// The end of the run of boundaries from `first` on that act on each node by itself.
  [[nodiscard]] std::size_t end_of_nodal(std::size_t first) const {
    std::size_t b = first;
    while (b < forces_.boundaries.size() && nodal(b)) ++b;
    return b;
  }

  /// Lets boundaries first .. last - 1 act on the nodes of block number i.
  void act_on_block(std::size_t i, std::size_t first, std::size_t last) {
    const std::int32_t index = grid_.all_blocks()[i];
    NodeBlock& nodes = grid_.nodes(index);
    const Index3& block = grid_.block(index).coordinate;
    const double dx = grid_.cell_size();
    const Vec3 low = node_position(block, 0, dx), high = low + Vec3::Constant((block_edge - 1) * dx);
    for (std::size_t b = first; b < last; ++b) {
      const std::size_t place = place_of(b);
      Vec3* const layers = place < forces_.layered.size() ? &by_layer_[place * layers_ + block_edge * i] : nullptr;
      std::visit(
          [&](const auto& boundary) {
            if constexpr (ActsOnNodes<std::decay_t<decltype(boundary)>>) {
              if (boundary.reaches(low, high, time_))
                taken_[i * forces_.boundaries.size() + b] = constrain_block(boundary, nodes, block, forces_.mirror, dx, time_, layers);
            }
          },
          forces_.boundaries[b]);
    }
  }

  /// Lets boundary b, which acts on several nodes together, act on the whole grid.
  void act(std::size_t b) {
    const Boundary& boundary = forces_.boundaries[b];
    if (const auto* solid = std::get_if<SurfaceSolid>(&boundary)) {
      ContactImpulse& impulse = contacts_[b] = apply_surface_contact(grid_, *solid);
      apply_folded_top(grid_, *solid, forces_.mirror, impulse);
    } else {
      const auto by_block = apply_folded_wall(grid_, boundary, forces_.mirror, time_);
      for (std::size_t i = 0; i < by_block.size(); ++i) taken_[i * forces_.boundaries.size() + b] = by_block[i];
    }
  }

  /// Sums block by block in the order of the blocks. @param mass  of each block
  GridUpdate result(std::vector<double> mass) && {
    if (Ranks* const ranks = grid_.ranks()) {
      gather_mass(*ranks, mass);
      gather_taken(*ranks);
      gather_contacts(*ranks);
    }
    const std::size_t count = forces_.boundaries.size();
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      for (std::size_t b = 0; b < count; ++b) update_.impulses[b] += taken_[i * count + b];
    }
    for (std::size_t k = 0; k < forces_.layered.size(); ++k) {
      if (nodal(forces_.layered[k])) update_.layers[k] = sum_of_layers(blocks_, std::span(by_layer_).subspan(k * layers_, layers_));
    }
    for (auto& [b, impulse] : contacts_) {
      update_.impulses[b] = impulse.total;
      if (const std::size_t place = place_of(b); place < forces_.layered.size()) update_.layers[place] = std::move(impulse.layers);
    }
    for (const double m : mass) update_.mass += m;
    return std::move(update_);
  }

 private:
  static std::vector<Index3> coordinates_of(const Grid& grid) {
    std::vector<Index3> coordinates;
    coordinates.reserve(grid.all_blocks().size());
    for (const auto b : grid.all_blocks()) coordinates.push_back(grid.block(b).coordinate);
    return coordinates;
  }

  // Afterwards the first rank has what one rank would have, but for blocks that took nothing, and the others have nothing.
  void gather_mass(Ranks& ranks, std::vector<double>& mass) const;
  void gather_taken(Ranks& ranks);
  void gather_contacts(Ranks& ranks);

  [[nodiscard]] bool nodal(std::size_t b) const {
    const Boundary& boundary = forces_.boundaries[b];
    const Wall* wall = plane_of(boundary);
    return !std::holds_alternative<SurfaceSolid>(boundary) &&
           (wall == nullptr || !folds(*wall, forces_.boundaries, forces_.mirror, grid_.cell_size(), time_));
  }
  /// Place of a boundary among those whose impulses are booked by layer; behind the last for another.
  [[nodiscard]] std::size_t place_of(std::size_t b) const {
    return static_cast<std::size_t>(std::ranges::find(forces_.layered, b) - forces_.layered.begin());
  }

  Grid& grid_;
  const GridForces& forces_;
  double time_;
  std::vector<Index3> blocks_;                      ///< whose parts follow
  std::size_t layers_;                              ///< of nodes, in all blocks
  std::vector<Impulse> taken_;                      ///< by block and boundary, of all but solids that act at their surface
  std::vector<Vec3> by_layer_;                      ///< by boundary, block and layer, of the nodal ones
  std::map<std::size_t, ContactImpulse> contacts_;  ///< by boundary, of solids that act at their surface
  GridUpdate update_;
};

void Boundaries::gather_mass(Ranks& ranks, std::vector<double>& mass) const {
  BlockTable table(1);
  for (std::size_t i = 0; i < blocks_.size(); ++i) table.add(blocks_[i], {&mass[i], 1});
  table.gather(ranks);
  mass.clear();
  for (std::size_t i = 0; i < table.size(); ++i) mass.push_back(table.row(i)[0]);
}

void Boundaries::gather_taken(Ranks& ranks) {
  const std::size_t count = forces_.boundaries.size(), layered = forces_.layered.size();
  const std::size_t of_impulses = impulse_numbers * count, of_layers = 3 * block_edge;
  BlockTable table(of_impulses + layered * of_layers);
  std::vector<double> row(of_impulses + layered * of_layers);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    std::memcpy(row.data(), static_cast<const void*>(taken_.data() + i * count), of_impulses * sizeof(double));
    for (std::size_t k = 0; k < layered; ++k)
      std::memcpy(row.data() + of_impulses + k * of_layers, by_layer_[k * layers_ + block_edge * i].data(), of_layers * sizeof(double));
    table.add_unless_zero(blocks_[i], row);
  }
  table.gather(ranks);
  blocks_.clear();
  layers_ = block_edge * table.size();
  taken_.assign(table.size() * count, {});
  by_layer_.assign(layered * layers_, Vec3::Zero());
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double* const numbers = table.row(i).data();
    blocks_.push_back(table.block(i));
    std::memcpy(static_cast<void*>(taken_.data() + i * count), numbers, of_impulses * sizeof(double));
    for (std::size_t k = 0; k < layered; ++k)
      std::memcpy(by_layer_[k * layers_ + block_edge * i].data(), numbers + of_impulses + k * of_layers, of_layers * sizeof(double));
  }
}

void Boundaries::gather_contacts(Ranks& ranks) {
  // rows in the order {boundary, kind, layer or turn}; the rows of a top all come from one rank
  enum Kind : std::int32_t { range, side, top };
  struct Row {
    double layer = 0.0;
    Impulse impulse;
  };
  auto table = BlockTable::of<Row>();
  for (const auto& [b, impulse] : contacts_) {
    const auto boundary = static_cast<std::int32_t>(b), first = impulse.layers.first;
    const auto count = static_cast<std::int32_t>(impulse.sides.size());
    const auto add = [&](std::int32_t place, Kind kind, double layer, const Impulse& taken) {
      const Row row{layer, taken};
      double numbers[sizeof(Row) / sizeof(double)];
      std::memcpy(numbers, static_cast<const void*>(&row), sizeof(Row));
      table.add({place, kind, boundary}, numbers);
    };
    if (count == 0) continue;
    add(first, range, first + count, {});
    for (std::int32_t k = 0; k < count; ++k) add(first + k, side, first + k, impulse.sides[static_cast<std::size_t>(k)]);
    for (std::size_t n = 0; n < impulse.top.size(); ++n)
      add(static_cast<std::int32_t>(n), top, impulse.top[n].layer, impulse.top[n].impulse);
  }
  table.gather(ranks);
  contacts_.clear();
  for (std::size_t i = 0; i < table.size();) {
    const std::int32_t boundary = table.block(i)[2], first = table.block(i)[0];  // the lowest of all ranges
    const auto is = [&](Kind kind) { return i < table.size() && table.block(i)[2] == boundary && table.block(i)[1] == kind; };
    std::int32_t end = first;
    for (; is(range); ++i) end = std::max(end, static_cast<std::int32_t>(table.get<Row>(i).layer));
    std::vector<Impulse> sides(static_cast<std::size_t>(end - first));
    for (; is(side); ++i) sides[static_cast<std::size_t>(table.block(i)[0] - first)] += table.get<Row>(i).impulse;
    ContactImpulse sum(first, std::move(sides));
    for (; is(top); ++i) sum.add_top(static_cast<std::int32_t>(table.get<Row>(i).layer), table.get<Row>(i).impulse);
    contacts_[static_cast<std::size_t>(boundary)] = std::move(sum);
  }
}

}  // namespace

GridUpdate update_grid(Grid& grid, const GridForces& forces, double dt, double time) {
  const auto all = grid.all_blocks();
  const Node gained = {dt * forces.gravity.x(), dt * forces.gravity.y(), dt * forces.gravity.z(), 0.0};
  std::vector<double> mass(all.size());
  Boundaries boundaries(grid, forces, time);
  std::size_t next = boundaries.end_of_nodal(0);
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < all.size(); ++i) {
    NodeBlock* const old = grid.keeps_old_nodes() ? &grid.old_nodes(all[i]) : nullptr;
    mass[i] = velocities_of(grid.nodes(all[i]), old, grid.block(all[i]).coordinate, forces.mirror, gained);
    boundaries.act_on_block(i, 0, next);
  }
  while (next < forces.boundaries.size()) {
    boundaries.act(next);
    const std::size_t first = next + 1;
    next = boundaries.end_of_nodal(first);
    if (next == first) continue;
#pragma omp parallel for schedule(static, 8)
    for (std::size_t i = 0; i < all.size(); ++i) boundaries.act_on_block(i, first, next);
  }
  reflect_velocities(grid, forces.mirror);

  return std::move(boundaries).result(std::move(mass));
}

}  // namespace mpm
