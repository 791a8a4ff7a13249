#include "libmpm/core/surface_contact.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "libmpm/base/lanes.hpp"

namespace mpm {

namespace {

constexpr int sweeps = 8;
constexpr int first_capped_sweep = 2;     ///< the caps compare impulses, which must be approximately right first
constexpr double apex_factor = 4.0;       ///< square of the speed of a flow over that at the nodes around an apex, where it parts
constexpr double least_weight = 0.3;      ///< sum of the weights of a point's nodes with material; below it the point has no contact
constexpr int group_layers = lane_count;  ///< solved at once
constexpr int group_blocks = group_layers / block_edge;

/// Velocities of a group of layers at the nodes of a stencil, and the impulses of its rows. Reused from group to group.
struct LayerGroup {
  struct NodeLanes {
    Lanes v[3], inverse_mass, mass;  ///< zero where there is no material
  };
  struct RowLanes {
    Lanes inverse_normal, inverse_tangent, inverse_vertical;  ///< 1/sum |g|^2/m; 0: the row is not active
    Lanes normal, tangent, vertical;                          ///< impulses per unit of the row
  };
  std::vector<NodeLanes> node;
  std::vector<RowLanes> row;
};

/// Storage of a stencil's nodes: its block columns, and for each node its column and its index in a block's layer.
struct NodePlaces {
  std::vector<std::array<std::int32_t, 2>> columns;
  std::vector<std::size_t> column;
  std::vector<int> place;  ///< x + 4 y

  explicit NodePlaces(const ContactStencil& stencil) {
    std::map<std::array<std::int32_t, 2>, std::size_t> numbers;
    for (const auto& node : stencil.nodes) {
      const std::array<std::int32_t, 2> at = {block_of_node(node.at[0]), block_of_node(node.at[1])};
      const auto [number, is_new] = numbers.try_emplace(at, columns.size());
      if (is_new) columns.push_back(at);
      column.push_back(number->second);
      place.push_back(number_of_node({node.at[0], node.at[1], first_node(0)}));
    }
  }
};

/// The blocks of a group of layers: [column][lower, upper], null if there is no block.
using GroupBlocks = std::vector<std::array<NodeBlock*, group_blocks>>;

/// Reads the velocities of a group of layers. @returns whether there is any material
bool load(const ContactStencil& stencil, const NodePlaces& places, const GroupBlocks& blocks, LayerGroup& group) {
  group.node.resize(stencil.nodes.size());
  bool any_mass = false;
  for (std::size_t n = 0; n < stencil.nodes.size(); ++n) {
    LayerGroup::NodeLanes& lanes = group.node[n];
    lanes.v[0] = lanes.v[1] = lanes.v[2] = lanes.inverse_mass = lanes.mass = Lanes{};
    for (int half = 0; half < group_blocks; ++half) {
      const NodeBlock* block = blocks[places.column[n]][static_cast<std::size_t>(half)];
      if (block == nullptr) continue;
      for (int k = 0; k < block_edge; ++k) {
        const Node& node = block->node[places.place[n] + k * node_stride(2)];
        if (node[3] <= 0.0) continue;
        any_mass = true;
        const int lane = block_edge * half + k;
        for (int i = 0; i < 3; ++i) lanes.v[i][lane] = node[i];
        lanes.mass[lane] = stencil.nodes[n].computed * node[3];
        lanes.inverse_mass[lane] = 1.0 / lanes.mass[lane];
      }
    }
  }
  return any_mass;
}

/// 1/x, and 0 where x is not above 0 or the lane is not active.
Lanes inverse_where(LaneMask active, Lanes x) { return active & (x > 0.0) ? 1.0 / x : Lanes{}; }

void prepare_rows(const ContactStencil& stencil, LayerGroup& group) {
  group.row.resize(stencil.rows.size());
  for (std::size_t r = 0; r < stencil.rows.size(); ++r) {
    const ContactRow& row = stencil.rows[r];
    Lanes weight{}, normal{}, tangent{}, vertical{};
    LaneMask all_there = ~LaneMask{};
    for (std::size_t e = row.first; e < row.first + row.count; ++e) {
      const ContactEntry& entry = stencil.entries[e];
      const Lanes inverse = group.node[static_cast<std::size_t>(entry.node)].inverse_mass;
      const LaneMask there = inverse > 0.0;
      weight += there ? Lanes{} + entry.vertical : Lanes{};
      all_there &= there;
      normal += entry.normal.squaredNorm() * inverse;
      tangent += entry.tangent.squaredNorm() * inverse;
      vertical += entry.vertical * entry.vertical * inverse;
    }
    const LaneMask active = row.kind == ContactRow::Kind::extension ? all_there : LaneMask(weight > least_weight);
    LayerGroup::RowLanes& state = group.row[r];
    state.inverse_normal = inverse_where(active, normal);
    state.inverse_tangent = inverse_where(active, tangent);
    state.inverse_vertical = inverse_where(active, vertical);
    state.normal = state.tangent = state.vertical = Lanes{};
  }
}

/// Solves one row for its nodes' present velocities and changes them.
/// @param bound  of the impulse at a point
template <bool frictional>
void solve_row(const ContactStencil& stencil, const ContactRow& row, double friction, Lanes bound, LayerGroup& group,
               LayerGroup::RowLanes& state) {
  Lanes u{}, ut{}, uz{};
  for (std::size_t e = row.first; e < row.first + row.count; ++e) {
    const ContactEntry& entry = stencil.entries[e];
    const LayerGroup::NodeLanes& node = group.node[static_cast<std::size_t>(entry.node)];
    u += entry.normal.x() * node.v[0] + entry.normal.y() * node.v[1];
    if constexpr (frictional) {
      ut += entry.tangent.x() * node.v[0] + entry.tangent.y() * node.v[1];
      uz += entry.vertical * node.v[2];
    }
  }
  Lanes normal = state.normal + u * state.inverse_normal;
  if (row.kind == ContactRow::Kind::point) {
    normal = min(max(normal, -bound), Lanes{});
  } else {
    normal = group.row[static_cast<std::size_t>(row.row_before)].normal < 0.0 ? normal : Lanes{};
  }
  const Lanes change = normal - state.normal;
  state.normal = normal;
  Lanes change_t{}, change_z{};
  if constexpr (frictional) {
    Lanes tangent = state.tangent + ut * state.inverse_tangent, vertical = state.vertical + uz * state.inverse_vertical;
    const Lanes size = sqrt(tangent * tangent + vertical * vertical), most = -friction * normal;
    const Lanes scale = size > most ? most / size : Lanes{} + 1.0;
    tangent *= scale;
    vertical *= scale;
    change_t = tangent - state.tangent;
    change_z = vertical - state.vertical;
    state.tangent = tangent;
    state.vertical = vertical;
  }
  for (std::size_t e = row.first; e < row.first + row.count; ++e) {
    const ContactEntry& entry = stencil.entries[e];
    LayerGroup::NodeLanes& node = group.node[static_cast<std::size_t>(entry.node)];
    Lanes x = entry.normal.x() * change, y = entry.normal.y() * change;
    if constexpr (frictional) {
      x += entry.tangent.x() * change_t;
      y += entry.tangent.y() * change_t;
      node.v[2] -= entry.vertical * change_z * node.inverse_mass;
    }
    node.v[0] -= x * node.inverse_mass;
    node.v[1] -= y * node.inverse_mass;
  }
}

/// Square of the velocity along the side at a point of it.
Lanes squared_speed_along(const ContactStencil& stencil, const ContactRow& row, const LayerGroup& group) {
  Lanes ut{}, uz{};
  for (std::size_t e = row.first; e < row.first + row.count; ++e) {
    const ContactEntry& entry = stencil.entries[e];
    const LayerGroup::NodeLanes& node = group.node[static_cast<std::size_t>(entry.node)];
    ut += entry.tangent.x() * node.v[0] + entry.tangent.y() * node.v[1];
    uz += entry.vertical * node.v[2];
  }
  return ut * ut + uz * uz;
}

/// Square of the largest velocity of a point's nodes.
Lanes largest_squared_speed(const ContactStencil& stencil, const ContactRow& row, const LayerGroup& group) {
  Lanes largest{};
  for (std::size_t e = row.first; e < row.first + row.count; ++e) {
    const LayerGroup::NodeLanes& node = group.node[static_cast<std::size_t>(stencil.entries[e].node)];
    largest = max(largest, node.v[0] * node.v[0] + node.v[1] * node.v[1] + node.v[2] * node.v[2]);
  }
  return largest;
}

/// Each sweep solves the extensions, then the points, so that the points hold at its end; every other sweep backwards.
/// @param dynamic  impulse of the dynamic pressure over the square of the velocity, on a strip of a layer one metre wide: rho/2 dx dt
void solve_rows(const ContactStencil& stencil, double friction, double dynamic, LayerGroup& group) {
  const std::size_t points = stencil.point_rows, extensions = stencil.rows.size() - points;
  const Lanes unbounded = Lanes{} + 1e300;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const auto in_turn = [&](std::size_t i, std::size_t count) { return sweep % 2 == 0 ? i : count - 1 - i; };
    for (std::size_t i = 0; i < extensions && sweep > 0; ++i) {
      const std::size_t r = points + in_turn(i, extensions);
      solve_row<false>(stencil, stencil.rows[r], friction, unbounded, group, group.row[r]);
    }
    for (std::size_t i = 0; i < points; ++i) {
      const std::size_t r = in_turn(i, points);
      const ContactRow& row = stencil.rows[r];
      Lanes bound = unbounded;
      if (const EdgeBound& edge = row.edge; edge.neighbour >= 0 && (edge.in_margin() || sweep >= first_capped_sweep)) {
        const auto impulse_of = [&](int other) {
          if (other < 0) return Lanes{};
          const auto o = static_cast<std::size_t>(other);
          return -group.row[o].normal * (row.computed / stencil.rows[o].computed);
        };
        const Lanes squared_speed =
            edge.in_margin() ? apex_factor * largest_squared_speed(stencil, row, group) : squared_speed_along(stencil, row, group);
        const Lanes fall = dynamic * edge.strip * row.computed * squared_speed;
        bound = max(edge.largest(impulse_of(edge.neighbour), fall), impulse_of(row.adjacent));
      }
      if (friction > 0.0) {
        solve_row<true>(stencil, row, friction, bound, group, group.row[r]);
      } else {
        solve_row<false>(stencil, row, friction, bound, group, group.row[r]);
      }
    }
  }
}

/// Nodes that no row touches obey the nearest side, independently. @param deep_layers  layers for which a side is nearer than top and
/// underside
void hold_deep_nodes(const ContactStencil& stencil, double friction, LaneMask deep_layers, LayerGroup& group) {
  for (const ContactStencil::Deep& deep : stencil.deep) {
    LayerGroup::NodeLanes& node = group.node[static_cast<std::size_t>(deep.node)];
    const Lanes approach = deep_layers ? min(deep.normal.x() * node.v[0] + deep.normal.y() * node.v[1], Lanes{}) : Lanes{};
    node.v[0] -= deep.normal.x() * approach;
    node.v[1] -= deep.normal.y() * approach;
    if (friction == 0.0) continue;
    const Lanes along = -deep.normal.y() * node.v[0] + deep.normal.x() * node.v[1];
    const Lanes speed = sqrt(along * along + node.v[2] * node.v[2]), loss = -friction * approach;
    const Lanes left = speed > loss ? 1.0 - loss / speed : approach < 0.0 ? Lanes{} : Lanes{} + 1.0;
    node.v[0] -= -deep.normal.y() * along * (1.0 - left);
    node.v[1] -= deep.normal.x() * along * (1.0 - left);
    node.v[2] *= left;
  }
}

/// Writes the velocities back. @param taken  the impulses of the layers
void store(const ContactStencil& stencil, const NodePlaces& places, const GroupBlocks& blocks, const LayerGroup& group, LaneMask acts,
           std::int32_t first_layer, double dx, const Vec3& reference, Impulse* taken) {
  for (std::size_t n = 0; n < stencil.nodes.size(); ++n) {
    const LayerGroup::NodeLanes& lanes = group.node[n];
    for (int half = 0; half < group_blocks; ++half) {
      NodeBlock* block = blocks[places.column[n]][static_cast<std::size_t>(half)];
      if (block == nullptr) continue;
      for (int k = 0; k < block_edge; ++k) {
        const int lane = block_edge * half + k;
        if (acts[lane] == 0 || lanes.mass[lane] <= 0.0) continue;
        Node& node = block->node[places.place[n] + k * node_stride(2)];
        const Vec3 after(lanes.v[0][lane], lanes.v[1][lane], lanes.v[2][lane]);
        const Vec3 given = lanes.mass[lane] * (Vec3(node[0], node[1], node[2]) - after);
        const Vec3 position = dx * Vec3(stencil.nodes[n].at[0], stencil.nodes[n].at[1], first_layer + lane);
        taken[lane].add(given, position - reference, Vec3::Zero());
        node = Node{after.x(), after.y(), after.z(), node[3]};
      }
    }
  }
}

}  // namespace

ContactImpulse apply_surface_contact(Grid& grid, const SurfaceSolid& solid, double density, double dt) {
  const ContactStencil& stencil = solid.stencil();
  const NodePlaces places(stencil);
  const double dx = grid.cell_size();

  std::int32_t lowest = 0, highest = -1;  // of the blocks in the stencil's columns
  for (const auto index : grid.own_blocks()) {
    const Index3& c = grid.block(index).coordinate;
    if (std::ranges::find(places.columns, std::array{c[0], c[1]}) == places.columns.end()) continue;
    if (highest < lowest) lowest = highest = c[2];
    lowest = std::min(lowest, c[2]);
    highest = std::max(highest, c[2]);
  }
  if (highest < lowest) return {};
  const std::int32_t first_group = lowest >> 1, groups = (highest >> 1) - first_group + 1;  // of layers that material may touch
  const std::int32_t first_layer = first_node(group_blocks * first_group);
  std::vector<Impulse> taken(static_cast<std::size_t>(group_layers * groups));  // by layer
  LayerGroup group;
  GroupBlocks blocks;
#pragma omp parallel for schedule(dynamic, 1) firstprivate(group, blocks)
  for (std::int32_t g = 0; g < groups; ++g) {
    const std::int32_t layer = first_layer + group_layers * g;
    LaneMask acts{};
    LaneMask deep_layers{};
    for (int k = 0; k < group_layers; ++k) {
      const double beyond = solid.solid().beyond(dx * (layer + k));
      acts[k] = beyond <= on_surface ? -1 : 0;
      deep_layers[k] = beyond + dx * ContactStencil::deep_from <= on_surface ? -1 : 0;
    }
    if (!any(acts)) continue;
    blocks.resize(places.columns.size());
    for (std::size_t c = 0; c < places.columns.size(); ++c) {
      for (int half = 0; half < group_blocks; ++half) {
        const std::int32_t index = grid.find({places.columns[c][0], places.columns[c][1], group_blocks * (first_group + g) + half});
        blocks[c][static_cast<std::size_t>(half)] = index == no_block ? nullptr : &grid.velocities(index);
      }
    }
    if (!load(stencil, places, blocks, group)) continue;
    prepare_rows(stencil, group);
    solve_rows(stencil, solid.friction(), 0.5 * density * dx * dt, group);
    hold_deep_nodes(stencil, solid.friction(), deep_layers, group);
    store(stencil, places, blocks, group, acts, layer, dx, solid.reference_point(), &taken[static_cast<std::size_t>(layer - first_layer)]);
  }
  return {.first = first_layer, .sides = std::move(taken)};
}

}  // namespace mpm
