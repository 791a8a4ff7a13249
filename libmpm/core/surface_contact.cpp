#include "libmpm/core/surface_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "libmpm/base/lanes.hpp"

namespace mpm {

namespace {

constexpr int sweeps = 8;
constexpr int first_capped_sweep = 2;  ///< the caps compare impulses, which must be approximately right first
constexpr double apex_factor = 4.0;    ///< (speed of a flow over that of the nodes at an apex)^2: where it parts, they have half of it
constexpr double least_weight = 0.3;   ///< sum of the weights of a point's nodes with material; below it the point has no contact
constexpr int group_layers = lanes_of<Lanes>;  ///< solved at once
constexpr int group_blocks = group_layers / block_edge;

/// The last layer of nodes inside, below the top or above the underside, or the next one if it is within half a cell of the face. What lies
/// beyond the face flows past, and the points stop only as much of these layers as the face carries.
struct EndLayer {
  std::int32_t layer = 0, inner = 0;  ///< numbers of it and of the next one inwards
  double height = 0.0;                ///< of the strip of the sides that it represents, m
  EdgeBound bound;                    ///< by the impulses of the layer inwards
  double rise = 0.0;  ///< impulse on one metre of it by which gravity raises the pressure from the layer inwards to the edge, N s/m
  std::vector<double> inner_normal = {};  ///< by row: impulse in the layer inwards

  /// Bound of the impulse of a row. @param width  of its strip in the computed part, m. @param fall  as in EdgeBound
  [[nodiscard]] Lanes largest(std::size_t row, double width, const Lanes& fall) const {
    return bound.largest(Lanes{} - inner_normal[row], fall) + width * rise;
  }
};

/// The layers at the faces of a solid, each after the one that bounds it. Of a solid too thin for a layer further inside there are none.
/// @param weight  density times gravity along z times dt, N s/m^3
std::vector<EndLayer> end_layers(const UprightSolid& solid, double dx, double weight) {
  std::vector<EndLayer> ends;
  for (const double outward : {1.0, -1.0}) {
    const double face = outward * (outward > 0.0 ? solid.top : solid.base) / dx;
    if (!std::isfinite(face)) continue;
    const double last = std::floor(face + cell_rounding);
    for (const double layer : {last, last + 1.0}) {
      const double depth = face - layer, inner = layer - 1.0, inner_depth = -solid.beyond(outward * dx * inner) / dx;
      if (depth < cell_rounding - 0.5 || inner_depth < depth + cell_rounding) continue;
      const double height = std::min(depth + 0.5, 1.0) * dx;
      ends.push_back({.layer = static_cast<std::int32_t>(outward * layer),
                      .inner = static_cast<std::int32_t>(outward * inner),
                      .height = height,
                      .bound = bound_by_depth(depth, inner_depth),
                      .rise = std::max(0.0, outward * weight) * (depth + 1.0) * height * dx});
    }
  }
  return ends;
}

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
/// @param end  the layer that is solved, if it is one; of the others the impulses are not used
/// @param dynamic  impulse of the dynamic pressure over the square of the velocity, on a strip of a layer one metre wide: rho/2 times the
/// height of the strip times dt
void solve_rows(const ContactStencil& stencil, double friction, double dynamic, const EndLayer* end, LayerGroup& group) {
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
      const double width = row.width * row.computed;
      Lanes bound = unbounded;
      if (const EdgeBound& edge = row.edge; edge.neighbour >= 0 && (edge.in_margin() || sweep >= first_capped_sweep)) {
        const auto impulse_of = [&](int other) {
          if (other < 0) return Lanes{};
          const auto o = static_cast<std::size_t>(other);
          return -group.row[o].normal * (row.computed / stencil.rows[o].computed);
        };
        const Lanes squared_speed =
            edge.in_margin() ? apex_factor * largest_squared_speed(stencil, row, group) : squared_speed_along(stencil, row, group);
        bound = max(edge.largest(impulse_of(edge.neighbour), dynamic * width * squared_speed), impulse_of(row.adjacent));
      }
      if (end != nullptr) bound = min(bound, end->largest(r, width, dynamic * width * squared_speed_along(stencil, row, group)));
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

/// The blocks in a stencil's columns from the lowest to the highest, in groups of layers that are solved at once.
class LayerContact {
 public:
  LayerContact(Grid& grid, const SurfaceSolid& solid, double density, double gravity, double dt)
      : grid_(grid),
        solid_(solid),
        places_(solid.stencil()),
        density_(density),
        dt_(dt),
        ends_(end_layers(solid.solid(), grid.cell_size(), density * gravity * dt)) {
    for (EndLayer& end : ends_) end.inner_normal.assign(solid.stencil().rows.size(), 0.0);
  }

  /// Solves all layers, those at an end last, each after the one that bounds it.
  ContactImpulse solve() {
    const auto [lowest, highest] = block_layers();
    if (highest < lowest) return {};
    const std::int32_t from = lowest >> 1, groups = (highest >> 1) - from + 1;
    first_layer_ = first_node(group_blocks * from);
    taken_.resize(static_cast<std::size_t>(group_layers * groups));
    LayerGroup group;
    GroupBlocks blocks;
#pragma omp parallel for schedule(dynamic, 1) firstprivate(group, blocks)
    for (std::int32_t g = from; g < from + groups; ++g) solve_group(g, nullptr, group, blocks);
    for (const EndLayer& end : ends_) {
      const std::int32_t g = block_of_node(end.layer) >> 1;
      if (g >= from && g < from + groups) solve_group(g, &end, group, blocks);
    }
    return {.first = first_layer_, .sides = std::move(taken_)};
  }

 private:
  /// From the lowest to the highest of the blocks in the stencil's columns.
  [[nodiscard]] std::pair<std::int32_t, std::int32_t> block_layers() const {
    std::int32_t lowest = 0, highest = -1;
    for (const auto index : grid_.own_blocks()) {
      const Index3& c = grid_.block(index).coordinate;
      if (std::ranges::find(places_.columns, std::array{c[0], c[1]}) == places_.columns.end()) continue;
      if (highest < lowest) lowest = highest = c[2];
      lowest = std::min(lowest, c[2]);
      highest = std::max(highest, c[2]);
    }
    return {lowest, highest};
  }

  /// @param end  the only layer that acts; null: all but end layers. @param group, blocks  storage
  void solve_group(std::int32_t g, const EndLayer* end, LayerGroup& group, GroupBlocks& blocks) {
    const ContactStencil& stencil = solid_.stencil();
    const double dx = grid_.cell_size();
    const std::int32_t first = first_node(group_blocks * g);
    LaneMask acts{};
    LaneMask deep_layers{};
    for (int k = 0; k < group_layers; ++k) {
      const std::int32_t layer = first + k;
      const double beyond = solid_.solid().beyond(dx * layer) / dx;
      const bool at_end = std::ranges::find(ends_, layer, &EndLayer::layer) != ends_.end();
      acts[k] = (end != nullptr ? layer == end->layer : beyond <= cell_rounding && !at_end) ? -1 : 0;
      deep_layers[k] = beyond + ContactStencil::deep_from <= cell_rounding ? -1 : 0;
    }
    if (!any(acts)) return;
    blocks.resize(places_.columns.size());
    for (std::size_t c = 0; c < places_.columns.size(); ++c) {
      for (int half = 0; half < group_blocks; ++half) {
        const std::int32_t index = grid_.find({places_.columns[c][0], places_.columns[c][1], group_blocks * g + half});
        blocks[c][static_cast<std::size_t>(half)] = index == no_block ? nullptr : &grid_.velocities(index);
      }
    }
    if (!load(stencil, places_, blocks, group)) return;
    prepare_rows(stencil, group);
    solve_rows(stencil, solid_.friction(), 0.5 * density_ * (end != nullptr ? end->height : dx) * dt_, end, group);
    hold_deep_nodes(stencil, solid_.friction(), deep_layers, group);
    keep_inner(first, acts, group);
    store(stencil, places_, blocks, group, acts, first, dx, solid_.reference_point(),
          &taken_[static_cast<std::size_t>(first - first_layer_)]);
  }

  /// Keeps the impulses of layers that bound others. @param first  number of the group's first layer. @param acts  those that were solved
  void keep_inner(std::int32_t first, const LaneMask& acts, const LayerGroup& group) {
    for (EndLayer& end : ends_) {
      const std::int32_t lane = end.inner - first;
      if (lane < 0 || lane >= group_layers || acts[lane] == 0) continue;
      for (std::size_t r = 0; r < end.inner_normal.size(); ++r) end.inner_normal[r] = group.row[r].normal[lane];
    }
  }

  Grid& grid_;
  const SurfaceSolid& solid_;
  NodePlaces places_;
  double density_, dt_;
  std::vector<EndLayer> ends_;
  std::int32_t first_layer_ = 0;
  std::vector<Impulse> taken_;  ///< by layer from first_layer_ on
};

}  // namespace

std::vector<LayerRange> layers_of_ends(const UprightSolid& solid, double cell_size) {
  std::vector<LayerRange> layers;
  for (const EndLayer& end : end_layers(solid, cell_size, 0.0)) {
    const std::int32_t outer = block_of_node(end.layer), inner = block_of_node(end.inner);
    layers.push_back({2, std::min(outer, inner), std::max(outer, inner)});
  }
  return layers;
}

ContactImpulse apply_surface_contact(Grid& grid, const SurfaceSolid& solid, double density, double gravity, double dt) {
  return LayerContact(grid, solid, density, gravity, dt).solve();
}

}  // namespace mpm
