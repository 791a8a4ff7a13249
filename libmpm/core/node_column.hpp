#pragma once
/// Contact of a column of nodes with a plane: the rule that second-order walls, horizontal faces of solids and uneven ground share.
///
/// The master m is the first node before the plane, the others behind it are its slaves. d_k is the distance of node k before the plane
/// along the column, in cells, negative behind it. The normal velocity relative to the surface goes linearly through zero on the plane:
/// v_k.n = c_k v_m.n with c_k = d_k/d_m. Neighbours are one cell apart, so that d_m (1 - c_1) = 1.
/// v_m = sum c_k m_k v_k / sum c_k^2 m_k is the projection of the node velocities onto that form, orthogonal in the kinetic-energy norm.
///
/// Nodes move up to 1.5 cells before the material that moves them. A separable surface therefore acts only once the material has reached
/// it. The masses tell: in material that fills the space from a gap g on, node k has the mass int_(g - d_k)^inf N, N its B-spline, so that
/// the mass behind the master over that of the master grows as the gap closes, whatever the density. A layer thinner than some 1.5 cells
/// counts as closed earlier: a single sheet of particles at a gap of 0.7 cells, a layer of one cell at 0.28.

#include <array>
#include <limits>
#include <optional>

#include "libmpm/base/bspline.hpp"
#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/impulse.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

inline constexpr double nearest_master = 0.5;  ///< least distance of a master from the plane, cells
/// Widest gap between material and a separable surface at which contact acts, cells: with 0.1 a bar rebounds at the right time
/// (validation case bar_on_wall); flows are the same to 0.1 % with 0.25.
inline constexpr double closed_gap = 0.1;

/// A node of the grid.
struct NodeAt {
  Node* node = nullptr;           ///< null if there is no block
  std::int32_t block = no_block;  ///< index of its block
  int number = 0;                 ///< in the block
};

/// Node `by` steps along an axis from a block's node, at most a block's edge; null if there is no block.
inline NodeAt node_at(Grid& grid, std::int32_t block, int number, int axis, int by) {
  const int moved = place_along(axis, number) + by;
  int offset[3] = {0, 0, 0};
  offset[axis] = moved < 0 ? -1 : moved >= block_edge ? 1 : 0;
  const std::int32_t to = grid.block(block).neighbour[static_cast<std::size_t>(direction_of(offset[0], offset[1], offset[2]))];
  if (to == no_block) return {};
  const int there = number + (by - block_edge * offset[axis]) * node_stride(axis);
  return {&grid.velocities(to).node[there], to, there};
}

/// A node of a column.
struct ColumnNode {
  NodeAt at;                                            ///< its storage
  double mass = 0.0;                                    ///< on the grid, kg; 0 if there is no block
  Vec3 before = Vec3::Zero(), velocity = Vec3::Zero();  ///< relative to the surface, before and after contact, m/s
};

/// What a column meets.
struct ColumnSurface {
  Vec3 normal;                   ///< unit, into the material
  Contact contact;               ///< of the surface
  double friction;               ///< mu
  Vec3 velocity = Vec3::Zero();  ///< m/s
  double gap = closed_gap;       ///< along the column: where it is wider, a separable surface does not act yet, cells
};

/// Which nodes a column has.
template <std::size_t count>
struct ColumnPlan {
  int axis, inward;             ///< along which it goes; +1 or -1, the step from a node to the next one behind it
  std::int32_t master;          ///< number of the master along the axis
  std::array<double, count> c;  ///< d_k/d_m
  std::size_t used = count;     ///< number of its nodes
};

/// The nodes of a column.
template <std::size_t count>
struct NodeColumn {
  std::array<ColumnNode, count> node;  ///< the master first
  std::array<double, count> c;         ///< d_k/d_m
};

/// Collects the nodes of a fresh column; those beyond plan.used keep no mass. @param block, number  of the master. @param surface  its
/// velocity, m/s. @returns whether any material is behind the master
template <std::size_t count>
bool collect_column(Grid& grid, std::int32_t block, int number, const ColumnPlan<count>& plan, const Vec3& surface,
                    NodeColumn<count>& column) {
  bool behind = false;
  for (std::size_t k = 0; k < plan.used; ++k) {
    ColumnNode& c = column.node[k];
    c.at = node_at(grid, block, number, plan.axis, plan.inward * static_cast<int>(k));
    if (c.at.node == nullptr || (*c.at.node)[3] <= 0.0) continue;
    c.mass = (*c.at.node)[3];
    c.before = Vec3((*c.at.node)[0], (*c.at.node)[1], (*c.at.node)[2]) - surface;
    behind |= k > 0;
  }
  return behind;
}

/// Whether the material of a column begins more than a gap before the plane. @param gap  cells
template <std::size_t count>
bool is_open(const NodeColumn<count>& column, double gap) {
  const double master = 1.0 / (1.0 - column.c[1]);  // d_m
  double behind = 0.0, behind_if_closed = 0.0;
  for (std::size_t k = 1; k < count; ++k) {
    behind += column.node[k].mass;
    behind_if_closed += bspline_tail(gap - master + static_cast<double>(k));
  }
  return behind * bspline_tail(gap - master) < behind_if_closed * column.node[0].mass;
}

/// Velocities of a column after contact. no_slip: all components go through zero; separable: only where the column as a whole has
/// reached the surface and is pushed against it. Coulomb friction takes from the tangential velocities v_t the same fraction s of the
/// change to sticking (v_t = c_k w), s <= 1 and s |J_stick| <= mu |J_n|. @param bound  of the normal impulse, kg m/s
/// @returns the normal impulse on the surface, positive for compression; empty if the column is free
template <std::size_t count>
std::optional<double> fold_column(NodeColumn<count>& column, const ColumnSurface& surface,
                                  double bound = std::numeric_limits<double>::infinity()) {
  const Vec3& normal = surface.normal;
  Vec3 momentum = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    momentum += column.c[k] * column.node[k].mass * column.node[k].before;
    mass += column.c[k] * column.c[k] * column.node[k].mass;
  }
  const Vec3 held = momentum / mass;  // velocity of the master if all stick
  Vec3 sticking = Vec3::Zero();       // impulse needed for that
  for (std::size_t k = 0; k < count; ++k) sticking += column.node[k].mass * (column.node[k].before - column.c[k] * held);
  const double tension = normal.dot(sticking);  // negative: material pushes against the surface
  if (surface.contact == Contact::separable && (tension >= 0.0 || is_open(column, surface.gap))) return std::nullopt;
  double fraction = 0.0;  // of the tangential change to sticking
  if (surface.contact == Contact::no_slip) {
    fraction = 1.0;
  } else if (surface.friction > 0.0 && tension < 0.0) {
    const double all = (sticking - tension * normal).norm(), most = -surface.friction * tension;
    fraction = all > most ? most / all : 1.0;
  }
  const double scale = -tension > bound ? bound / -tension : 1.0;  // factor of all impulses
  for (std::size_t k = 0; k < count; ++k) {
    ColumnNode& n = column.node[k];
    const Vec3 stuck = column.c[k] * held;
    n.velocity = n.before + fraction * (stuck - n.before);
    n.velocity = n.velocity - normal.dot(n.velocity) * normal + normal.dot(stuck) * normal;  // exact for a normal along an axis
    if (scale < 1.0) n.velocity = n.before + scale * (n.velocity - n.before);
  }
  return -scale * tension;
}

/// The same; without material at the master each node behind it meets the surface alone. @returns whether velocities may have changed
template <std::size_t count>
bool act_on_column(NodeColumn<count>& column, const ColumnSurface& surface) {
  if (column.node[0].mass > 0.0) return fold_column(column, surface).has_value();
  for (ColumnNode& n : column.node)
    n.velocity = contact_velocity(n.before, surface.normal, Vec3::Zero(), surface.contact, surface.friction);
  return true;
}

/// Sets a node's velocity, relative to a surface. @param impulse  the momentum that the node loses, times its computed_fraction(), is added
inline void set_velocity(const Grid& grid, const NodeAt& at, const MirrorPlanes& mirror, const Vec3& surface, const Vec3& velocity,
                         const Vec3& reference, Impulse& impulse) {
  const Index3& block = grid.block(at.block).coordinate;
  Node& node = *at.node;
  const Vec3 after = surface + velocity;
  const Vec3 given = computed_fraction(mirror, block, at.number) * node[3] * (Vec3(node[0], node[1], node[2]) - after);
  impulse.add(given, node_position(block, at.number, grid.cell_size()) - reference, surface);
  node = Node{after.x(), after.y(), after.z(), node[3]};
}

/// Lets a surface act at a node: at a master on its column, behind it on the node alone, if no column reaches it from an existing block.
/// @param block, number  of the node. @param behind  steps from the master's layer, 0 or more
/// @param reference  of the moment, m. @param taken  the impulse on the surface is added to it
template <std::size_t count>
void act_at_node(Grid& grid, std::int32_t block, int number, std::int32_t behind, const ColumnPlan<count>& plan,
                 const ColumnSurface& surface, const MirrorPlanes& mirror, const Vec3& reference, Impulse& taken) {
  const Vec3& moving = surface.velocity;
  const auto write = [&](const NodeAt& at, const Vec3& velocity) { set_velocity(grid, at, mirror, moving, velocity, reference, taken); };
  if (behind > 0) {
    if (behind < static_cast<std::int32_t>(plan.used) && node_at(grid, block, number, plan.axis, -plan.inward * behind).node != nullptr)
      return;
    Node& node = grid.velocities(block).node[number];
    if (node[3] <= 0.0) return;
    const Vec3 before(node[0], node[1], node[2]);
    write({&node, block, number}, contact_velocity(before, surface.normal, moving, surface.contact, surface.friction) - moving);
    return;
  }
  NodeColumn<count> column{{}, plan.c};
  if (!collect_column(grid, block, number, plan, moving, column) || !act_on_column(column, surface)) return;
  for (const ColumnNode& c : column.node) {
    if (c.mass > 0.0) write(c.at, c.velocity);
  }
}

}  // namespace mpm
