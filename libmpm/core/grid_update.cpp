#include "libmpm/core/grid_update.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <memory>
#include <type_traits>

#include "libmpm/core/folded_terrain.hpp"
#include "libmpm/core/folded_wall.hpp"
#include "libmpm/core/lumped_mass.hpp"

namespace mpm {

namespace {

/// Velocities from momenta, with the change by gravity in dt. Returns the mass of the computed part, kg.
/// @param old  not null: holds the momentum that internal forces give, and gets the velocities before forces
double velocities_of(NodeBlock& nodes, NodeBlock* old, const Index3& block, const MirrorPlanes& mirror, const Node& gained) {
  const bool cut = is_cut(mirror, block);
  double mass = 0.0;
  for (int i = 0; i < block_nodes; ++i) {
    Node& n = nodes.node[i];
    const double m = n[3];
    mass += cut ? computed_fraction(mirror, block, i) * m : m;
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

/// Adds the impulses on the four layers of each block, in the order of the blocks.
/// @param table  rows of twelve numbers, of the blocks with impulses
LayerImpulses sum_of_layers(const BlockTable& table) {
  constexpr std::int32_t edge = block_edge;
  LayerImpulses sum;
  if (table.size() == 0) return sum;
  std::int32_t lowest = table.block(0)[2], highest = lowest;
  for (std::size_t i = 1; i < table.size(); ++i) {
    lowest = std::min(lowest, table.block(i)[2]);
    highest = std::max(highest, table.block(i)[2]);
  }
  sum.first = first_node(lowest);
  sum.layer.assign(static_cast<std::size_t>(edge * (highest - lowest + 1)), Vec3::Zero());
  for (std::size_t i = 0; i < table.size(); ++i) {
    Vec3* const layers = &sum.layer[static_cast<std::size_t>(edge * (table.block(i)[2] - lowest))];
    for (int k = 0; k < edge; ++k) layers[k] += Eigen::Map<const Vec3>(table.row(i).data() + 3 * k);
  }
  return sum;
}

constexpr std::size_t impulse_numbers = 7;
constexpr std::size_t layer_numbers = 3 * block_edge;  ///< of a block: an impulse for each layer of its nodes
static_assert(sizeof(Impulse) == impulse_numbers * sizeof(double) && sizeof(Vec3) == 3 * sizeof(double));

/// Whether an impulse would change a sum; most blocks touch no boundary.
bool anything(const Impulse& part) {
  static const Impulse nothing;
  return std::memcmp(static_cast<const void*>(&part), static_cast<const void*>(&nothing), sizeof(Impulse)) != 0;
}

/// Applies a scene's boundaries, one after another, and records the impulse on each.
class Boundaries {
 public:
  /// @param blocks  of Grid::all_blocks(), all or some, on which the boundaries act; solids with contact at their surface act on all
  Boundaries(Grid& grid, const GridForces& forces, double dt, double time, std::span<const std::int32_t> blocks)
      : grid_(grid),
        forces_(forces),
        dt_(dt),
        time_(time),
        blocks_(blocks),
        layers_(block_edge * blocks.size()),
        taken_(blocks.size() * forces.boundaries.size()),
        by_layer_(forces.layered.size() * layers_, Vec3::Zero()) {}

  /// The end of the run of boundaries from `first` on that act on each node by itself.
  [[nodiscard]] std::size_t end_of_nodal(std::size_t first) const {
    std::size_t b = first;
    while (b < forces_.boundaries.size() && nodal(b)) ++b;
    return b;
  }

  /// Lets boundaries first .. last - 1 act on the nodes of the i-th block.
  void act_on_block(std::size_t i, std::size_t first, std::size_t last) {
    const std::int32_t index = blocks_[i];
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

  /// Lets boundary b act, which acts on several nodes together.
  void act(std::size_t b) {
    const Boundary& boundary = forces_.boundaries[b];
    if (const auto* solid = std::get_if<SurfaceSolid>(&boundary)) {
      ContactImpulse& impulse = contacts_[b] = apply_surface_contact(grid_, *solid, forces_.density, dt_);
      apply_folded_faces(grid_, *solid, forces_.mirror, forces_.density, dt_, impulse);
    } else {
      const auto* const terrain = std::get_if<Terrain>(&boundary);
      const auto by_block = terrain != nullptr ? apply_folded_terrain(grid_, *terrain, forces_.mirror, blocks_)
                                               : apply_folded_wall(grid_, boundary, forces_.mirror, time_, blocks_);
      for (std::size_t i = 0; i < by_block.size(); ++i) taken_[i * forces_.boundaries.size() + b] = by_block[i];
    }
  }

  /// Lets boundaries first, first + 1, ... to the last act, in turn.
  void act_from(std::size_t first) {
    while (first < forces_.boundaries.size()) {
      act(first);
      const std::size_t next = first + 1;
      first = end_of_nodal(next);
      if (first == next) continue;
#pragma omp parallel for schedule(static, 8)
      for (std::size_t i = 0; i < blocks_.size(); ++i) act_on_block(i, next, first);
    }
  }

  /// What was recorded. @param mass  of each block
  GridUpdatePart result(std::span<const double> mass) && {
    const std::size_t count = forces_.boundaries.size();
    GridUpdatePart part(count, forces_.layered);
    for (const double m : mass) part.add_mass(m);
    for (std::size_t n = 0; n < taken_.size(); ++n) part.add_impulse(n % count, taken_[n]);
    for (std::size_t k = 0; k < forces_.layered.size(); ++k) {
      if (!nodal(forces_.layered[k])) continue;
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const double* const numbers = by_layer_[k * layers_ + block_edge * i].data();
        part.add_layers(k, grid_.block(blocks_[i]).coordinate, {numbers, layer_numbers});
      }
    }
    for (auto& [b, impulse] : contacts_) part.add_contact(b, std::move(impulse));
    return part;
  }

 private:
  [[nodiscard]] bool nodal(std::size_t b) const {
    const Boundary& boundary = forces_.boundaries[b];
    if (const auto* const terrain = std::get_if<Terrain>(&boundary)) return terrain->rule == ContactRule::nodal;
    const Wall* wall = plane_of(boundary);
    return acts_on_nodes(boundary) && (wall == nullptr || !folds(*wall, forces_.boundaries, forces_.mirror, grid_.cell_size(), time_));
  }
  /// Index of a boundary among those whose impulses are recorded by layer; past the end for the others.
  [[nodiscard]] std::size_t place_of(std::size_t b) const {
    return static_cast<std::size_t>(std::ranges::find(forces_.layered, b) - forces_.layered.begin());
  }

  Grid& grid_;
  const GridForces& forces_;
  double dt_, time_;
  std::span<const std::int32_t> blocks_;
  std::size_t layers_;                              ///< of nodes, in these blocks
  std::vector<Impulse> taken_;                      ///< by block and boundary, of all but solids that act at their surface
  std::vector<Vec3> by_layer_;                      ///< by boundary, block and layer, of the nodal ones
  std::map<std::size_t, ContactImpulse> contacts_;  ///< by boundary, of solids that act at their surface
};

/// A rectangle of columns of blocks: their coordinates x, y.
using Columns = Eigen::AlignedBox2i;

/// The same with columns before and behind it, along x and along y.
Columns extended(const Columns& columns, int before, int behind) {
  return {columns.min() - Eigen::Vector2i::Constant(before), columns.max() + Eigen::Vector2i::Constant(behind)};
}

std::vector<std::int32_t> blocks_in(const Grid& grid, const Columns& columns) {
  std::vector<std::int32_t> blocks;
  for (const auto b : grid.all_blocks()) {
    const Index3& block = grid.block(b).coordinate;
    if (columns.contains(Eigen::Vector2i(block[0], block[1]))) blocks.push_back(b);
  }
  return blocks;
}

/// The correction of lumped_mass.hpp for all solids that act at their surface. The accelerations are those with all boundaries: near the
/// solids these act once for them, and the velocities are set back. @param first  boundaries from this one on have not acted yet
void correct_lumped_mass(Grid& grid, const GridForces& forces, std::size_t first, double dt, double time) {
  const auto corrections = lumped_mass_corrections(forces.boundaries, grid.cell_size(), forces.density, forces.relaxed);
  if (corrections.empty() || !grid.keeps_old_nodes()) return;

  Columns columns;  // with particles that may take part
  for (const LumpedMassCorrection& correction : corrections) columns.extend(correction.columns());
  // Particles touch their own column and the next. Columns of nodes along x or y reach into one more on both sides; those that begin in
  // blocks where the boundaries act end at most one further.
  const auto acted = blocks_in(grid, extended(columns, 1, 2)), changed = blocks_in(grid, extended(columns, 2, 3));
  const std::size_t count = grid.numbers();
  const auto free = std::make_unique_for_overwrite<NodeBlock[]>(count);  // both by number of block
  const auto change = std::make_unique_for_overwrite<NodeBlock[]>(count);
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < changed.size(); ++i) {
    free[static_cast<std::size_t>(changed[i])] = grid.nodes(changed[i]);
    change[static_cast<std::size_t>(changed[i])] = NodeBlock{};
  }
  for (const auto b : grid.lent()) change[static_cast<std::size_t>(b)] = NodeBlock{};
  Boundaries(grid, forces, dt, time, acted).act_from(first);
  reflect_velocities(grid, forces.mirror, acted);
  Ranks* const ranks = grid.ranks();
  const std::span changes(change.get(), count);
  const auto near = [&](const Index3& block) {
    return std::ranges::any_of(corrections, [&](const LumpedMassCorrection& c) { return c.reaches(block[0], block[1]); });
  };
  if (ranks != nullptr) ranks->send_nodes(grid, near);
  for (const LumpedMassCorrection& correction : corrections) correction.add_inner(grid, changes);
  if (ranks != nullptr) {
    ranks->receive_nodes(grid);
    for (const LumpedMassCorrection& correction : corrections) correction.add_outer(grid, changes);
    ranks->send_parts(changes, near);
    ranks->add_parts(changes);
  }
  fold_mirror_planes(grid, forces.mirror, changes, acted);
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < changed.size(); ++i) {
    const NodeBlock &before = free[static_cast<std::size_t>(changed[i])], &gained = change[static_cast<std::size_t>(changed[i])];
    for (int n = 0; n < block_nodes; ++n) {
      const double mass = before.node[n][3];
      grid.nodes(changed[i]).node[n] = mass > 0.0 ? before.node[n] + gained.node[n] / mass : before.node[n];
    }
  }
}

}  // namespace

GridUpdatePart::GridUpdatePart(std::size_t boundaries, std::span<const std::size_t> layered)
    : layered_(layered),
      boundaries_(boundaries),
      sums_(1 + impulse_numbers * boundaries),
      layers_(layered.size(), BlockTable(layer_numbers)) {}

void GridUpdatePart::add_impulse(std::size_t b, const Impulse& taken) {
  if (anything(taken)) sums_.add_part(1 + impulse_numbers * b, taken);
}

void GridUpdatePart::add_to_contact(std::size_t b, std::int32_t layer, const Impulse& taken) {
  ContactImpulse& contact = contacts_[b];
  std::vector<Impulse>& sides = contact.sides;
  if (sides.empty()) contact.first = layer;
  if (layer < contact.first) {  // beside the columns of the stencil there may be material in other layers
    sides.insert(sides.begin(), static_cast<std::size_t>(contact.first - layer), Impulse{});
    contact.first = layer;
  }
  const auto place = static_cast<std::size_t>(layer - contact.first);
  if (place >= sides.size()) sides.resize(place + 1);
  sides[place] += taken;
}

/// Afterwards the first rank has the impulses of a run on one rank, and the others have none.
void GridUpdatePart::gather_contacts(Ranks& ranks) {
  // rows in the order {boundary, kind, layer or turn}; those of a top, or of an underside, all come from one rank
  enum Kind : std::int32_t { range, side, top, underside };
  struct Row {
    double layer = 0.0;
    Impulse impulse;
  };
  auto table = BlockTable::of<Row>();
  for (const auto& [b, impulse] : contacts_) {
    const auto boundary = static_cast<std::int32_t>(b), first = impulse.first;
    const auto count = static_cast<std::int32_t>(impulse.sides.size());
    const auto add = [&](std::int32_t place, Kind kind, double layer, const Impulse& taken) {
      table.add_part({place, kind, boundary}, Row{layer, taken});
    };
    if (count == 0) continue;
    add(first, range, first + count, {});
    for (std::int32_t k = 0; k < count; ++k) add(first + k, side, first + k, impulse.sides[static_cast<std::size_t>(k)]);
    for (const Kind face : {top, underside}) {
      const auto& parts = impulse.faces[face - top];
      for (std::size_t n = 0; n < parts.size(); ++n) add(static_cast<std::int32_t>(n), face, parts[n].layer, parts[n].impulse);
    }
  }
  table.gather(ranks);
  contacts_.clear();
  for (std::size_t i = 0; i < table.size();) {
    const std::int32_t boundary = table.block(i)[2], first = table.block(i)[0];  // the lowest of all ranges
    const auto is = [&](Kind kind) { return i < table.size() && table.block(i)[2] == boundary && table.block(i)[1] == kind; };
    std::int32_t end = first;
    for (; is(range); ++i) end = std::max(end, static_cast<std::int32_t>(table.get<Row>(i).layer));
    ContactImpulse sum{.first = first, .sides = std::vector<Impulse>(static_cast<std::size_t>(end - first))};
    for (; is(side); ++i) sum.sides[static_cast<std::size_t>(table.block(i)[0] - first)] += table.get<Row>(i).impulse;
    for (const Kind face : {top, underside}) {
      for (; is(face); ++i)
        sum.faces[face - top].push_back({static_cast<std::int32_t>(table.get<Row>(i).layer), table.get<Row>(i).impulse});
    }
    contacts_[static_cast<std::size_t>(boundary)] = std::move(sum);
  }
}

GridUpdate GridUpdatePart::sum(Ranks* ranks) && {
  sums_.add_ranks(ranks);
  GridUpdate whole;
  whole.mass = sums_.value(0);
  for (std::size_t b = 0; b < boundaries_; ++b) whole.impulses.push_back(sums_.part<Impulse>(1 + impulse_numbers * b));
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    if (ranks != nullptr && !contacts_.contains(layered_[k])) layers_[k].gather(*ranks);
    whole.layers.push_back(sum_of_layers(layers_[k]));
  }
  if (ranks != nullptr && !contacts_.empty()) gather_contacts(*ranks);
  for (const auto& [b, impulse] : contacts_) {
    whole.impulses[b] = impulse.total();
    const auto place = std::ranges::find(layered_, b);
    if (place != layered_.end()) whole.layers[static_cast<std::size_t>(place - layered_.begin())] = impulse.layers();
  }
  return whole;
}

GridUpdatePart update_grid(Grid& grid, const GridForces& forces, double dt, double time) {
  const auto all = grid.all_blocks();
  const Node gained = {dt * forces.gravity.x(), dt * forces.gravity.y(), dt * forces.gravity.z(), 0.0};
  std::vector<double> mass(all.size());
  Boundaries boundaries(grid, forces, dt, time, all);
  const std::size_t next = boundaries.end_of_nodal(0);
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < all.size(); ++i) {
    NodeBlock* const old = grid.keeps_old_nodes() ? &grid.old_nodes(all[i]) : nullptr;
    mass[i] = velocities_of(grid.nodes(all[i]), old, grid.block(all[i]).coordinate, forces.mirror, gained);
    boundaries.act_on_block(i, 0, next);
  }
  correct_lumped_mass(grid, forces, next, dt, time);
  boundaries.act_from(next);
  reflect_velocities(grid, forces.mirror, all);

  return std::move(boundaries).result(mass);
}

}  // namespace mpm
