#pragma once
/// Contact of a vertical solid in the plane of one layer of grid nodes: the points of its surface at which contact acts, and the nodes on
/// which it acts.
///
/// A nodal rule ("a node inside the solid obeys its nearest face") moves the surface to the nodes, and is of first order. Here the surface
/// keeps its position. The velocity of the material at a point s of the surface is u = sum_k g_k v_k with the B-spline weights g_k of the
/// nodes k at s; contact requires u.n >= 0 there, which an impulse lambda <= 0 along the row sum_k g_k n of the nodes achieves:
/// v_k -= g_k n lambda / m_k. Points of a straight side are one cell apart, so that there are as many conditions as nodes along it.
/// On a curved surface n is the normal at the node's own position, n_k: a flow along a circle has v_k.n_k = 0 at every node. With the
/// normal of the point at all nodes a flow that speeds up along the surface would count as an approach, dv/ds sigma^2/R, and be pushed off.
/// Points of a circle are half a cell apart: the place where a flow separates then does not depend on the points (one per cell: force on a
/// cylinder in a jet by 8 % from one place of the grid to another; two: by 4 %; three and four change it by less than 1 %).
///
/// A plane of nodes that lies on the surface has three rows of nodes with weights 1/8, 3/4, 1/8; the contact condition
/// constrains only their weighted sum. The extension condition removes the remaining freedom: the normal velocity is extrapolated linearly
/// behind the surface, v_k - 2 v_k+1 + v_k+2 = 0, by impulses of either sign whose sum is zero. On a plane of nodes both together are the
/// exact mirror image, v_0.n = 0, v_-1.n = -v_1.n.
///
/// The end points of a side also act on nodes beyond the edge: a side whose points fill it acts as if it were wider. So the points of a
/// long side stand on its part between the margins, edge_margin from each edge, at a distance d from each other, and an end point
/// represents the strip from its edge to half-way to the next point, margin + d wide. How much it takes of the next point's impulse depends
/// on the flow:
/// - At rest the pressure is uniform: (margin + d)/d.
/// - Where a flow leaves the edge, the pressure falls to zero like the square root of the distance s from it (Kirchhoff's plate:
///   p = rho U^2/2 (1 - tau^2), and s ~ (1 - tau)^2): int_0^(margin + d) sqrt(s) ds / int_(margin + d)^(margin + 2 d) sqrt(s) ds.
/// - In between, Bernoulli's law bounds the fall of the pressure towards the edge by rho v_t^2/2, v_t the speed along the side at the end
///   point.
/// The impulse of the end point is therefore at most that at rest less the smaller of Bernoulli's bound and the difference of the two.
///
/// Material at rest round the edge presses on both of its sides and on the margins, which would let it in. Each margin has a point of its
/// own, whose impulse is at most that of the end point of the side round the edge, by width, less Bernoulli's bound for the fastest node.
/// Where a flow leaves the edge, the side round it is free; where it parts at an apex, it is fast. In both the margin takes nothing.
///
/// The sides are vertical: one stencil serves all layers of nodes.
///
/// Top and underside act on columns of nodes (core/folded_wall.hpp). A column represents the strip of the face within half a cell of it.
/// The last columns before an edge, those less than half a cell from it on either side, are bounded by the same laws as the end points of a
/// side: the strip of a column at a depth d inside the edge ends at d + 1/2, and begins at the edge or at d - 1/2. So are, point by point,
/// the layers of the sides at the top and at the underside: the last one inside, and the next where it is less than half a cell outside
/// (core/surface_contact.hpp).

#include <array>
#include <vector>

#include "libmpm/base/lanes.hpp"
#include "libmpm/boundary/outline.hpp"

namespace mpm {

/// What bounds the impulse of a strip of a face at an edge.
struct EdgeBound {
  int neighbour = -1;                ///< number of the next one inwards, in a margin of the end point round the edge; -1: no bound
  double at_rest = 1.0, free = 1.0;  ///< impulse over that of the neighbour: under a uniform pressure; where a flow leaves the edge

  /// Of the point in a margin, not of an end point: only a margin takes nothing where a flow leaves the edge.
  [[nodiscard]] bool in_margin() const { return free == 0.0; }

  /// @param neighbour_impulse  towards the face. @param fall  impulse of the dynamic pressure along the face on this strip
  template <class T>
  [[nodiscard]] T largest(const T& neighbour_impulse, const T& fall) const {
    return at_rest * neighbour_impulse - min((at_rest - free) * neighbour_impulse, fall);
  }
};

/// That of a column or layer of nodes beside an edge, all of which represent half a cell to both sides.
/// @param depth, inner  of it and of the next one inwards: cells inside the edge. @returns without `neighbour`
[[nodiscard]] EdgeBound bound_by_depth(double depth, double inner);

/// One condition on the velocities of a layer's nodes.
struct ContactRow {
  /// point: no approach there, an impulse of one sign; extension: the normal velocity continues linearly, an impulse of either sign.
  enum class Kind { point, extension } kind = Kind::point;  ///< which of them
  std::size_t first = 0, count = 0;                         ///< its entries
  Vec2 point = Vec2::Zero();                                ///< m: on the surface, or the node that is extended to
  double width = 0.0;                                       ///< of the strip of the side that a point represents, m
  EdgeBound edge;                                           ///< of the end points of a side with at least three, and of its margins
  int adjacent = -1;                                        ///< of an end point: row of the end point of the side round the edge
  int row_before = -1;    ///< of an extension: row of the point before it; the extension acts only while that is in contact
  double computed = 1.0;  ///< fraction of its impulse in the computed part: a half for a point on a mirror plane, its own image
};

/// Coefficients of one node in a row; their sum if a mirror plane maps two nodes onto one.
struct ContactEntry {
  int node = 0;                 ///< number in ContactStencil::nodes
  Vec2 normal = Vec2::Zero();   ///< g n
  Vec2 tangent = Vec2::Zero();  ///< g t, t the horizontal tangent
  double vertical = 0.0;        ///< g
};

/// The conditions of one layer of nodes, and those nodes.
struct ContactStencil {
  /// A node of the layer, in the frame of the grid.
  struct PlaneNode {
    std::array<int, 2> at{};  ///< grid coordinates x, y
    double computed = 1.0;    ///< fraction of its mass in the computed part: a half on a mirror plane
  };
  /// Cells at both ends of a long side whose points act only with material round the edge. Calibrated with a plate in a jet (force 0.99 to
  /// 1.01 of the exact one with six and seven cells); judged by other cases. 0.25 and 0.3: the plate 0.98 to 1.01 and 0.97 to 1.00,
  /// Prandtl's punch with eight cells 1.06 and 1.05 in place of 1.07.
  static constexpr double edge_margin = 0.2;
  static constexpr int points_on_circle = 2;  ///< of one cell's length
  static constexpr double deep_from = 1.6;    ///< cells behind a surface: beyond the support of the points on it
  /// A node so deep inside that no row reaches it.
  struct Deep {
    int node = 0;                ///< number in ContactStencil::nodes
    Vec2 normal = Vec2::Zero();  ///< outward, of the nearest side
  };
  /// A column of nodes on the top or the underside.
  struct Column {
    int node = 0;        ///< number in ContactStencil::nodes
    double strip = 0.0;  ///< width of the strip next to an edge that it represents, m
    EdgeBound edge;      ///< `neighbour` in ContactStencil::columns: the next one inwards
  };
  std::vector<PlaneNode> nodes;       ///< referred to by index in rows, deep and columns
  std::vector<ContactRow> rows;       ///< those of points first
  std::size_t point_rows = 0;         ///< number of these
  std::vector<ContactEntry> entries;  ///< of all rows, row by row
  std::vector<Deep> deep;             ///< nodes that act alone
  std::vector<Column> columns;        ///< less than half a cell outside the outline, or inside; those further inside first
};

/// @param outline  m, in the frame of the grid. @param cell_size  m
/// @param mirror  rows of what is not computed are left out, its nodes replaced by their images
[[nodiscard]] ContactStencil contact_stencil(const Outline& outline, double cell_size, const MirrorPlanes& mirror);

}  // namespace mpm
