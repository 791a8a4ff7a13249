#include "libmpm/boundary/contact_stencil.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "libmpm/base/bspline.hpp"

namespace mpm {

namespace {

constexpr double extended_from = 0.5;       // cells behind the surface: nearer nodes are held by the points
constexpr double extended_to = 2.6;         // cells behind the surface: end of the support of points before it
constexpr double ambiguous_distance = 0.5;  // cells: between two sides of equal distance the direction to extend along is ambiguous

constexpr double no_direction = 0.5;  // cells: closer to the centre of a circle the direction of a node is undefined

/// B-spline weights of nodes first .. first + 2 along one axis, at a fixed position.
struct FixedWeights {
  /// @param x  position, in cells
  explicit FixedWeights(double x) : first(base_node(x)) {
    const BsplineWeights<double> n = bspline_weights(x - first);
    w = {n.n0, n.n1, n.n2};
  }
  int first;
  std::array<double, 3> w{};
};

/// A point of the surface, in cells.
struct SurfacePoint {
  Vec2 at, normal;
  double width;
  EdgeBound edge = {};  ///< as ContactRow::edge, with the number of a point in place of a row
  int adjacent = -1;    ///< as ContactRow::adjacent, with the number of a point in place of a row
};

/// @param circle  in cells
std::vector<SurfacePoint> points_of_circle(const Circle& circle) {
  const double half_way_round = ContactStencil::points_on_circle * std::numbers::pi * circle.radius;
  const int count = std::max(4, 2 * static_cast<int>(std::lround(half_way_round)));  // even: symmetric about both axes
  const double width = 2.0 * std::numbers::pi * circle.radius / count;
  std::vector<SurfacePoint> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / count;
    const Vec2 normal(std::cos(angle), std::sin(angle));
    points.push_back({circle.centre + circle.radius * normal, normal, width});
  }
  return points;
}

/// Impulse on a strip of a side next to the edge, over that on the next strip, where the pressure grows like the square root of the
/// distance.
/// @param first, next  their widths
double free_ratio(double first, double next) {
  const double here = std::pow(first, 1.5);
  return here / (std::pow(first + next, 1.5) - here);
}

std::vector<SurfacePoint> points_of_polygon(const Outline& outline, double cell_size) {
  constexpr int fewest = 3;  // a side with fewer points has no inner point to compare its ends with
  struct Strips {            // of a side
    int first;               // point of the first
    int count;               // between the margins
    double width, margin;    // cells
    [[nodiscard]] int start() const { return first + (margin > 0.0 ? 1 : 0); }
    [[nodiscard]] int end() const { return start() + count - 1; }
  };
  std::vector<SurfacePoint> points;
  const auto point = [&](int number) -> SurfacePoint& { return points[static_cast<std::size_t>(number)]; };
  std::vector<Strips> sides;
  for (const Outline::Side& side : outline.sides()) {
    const Vec2 whole = (side.to - side.from) / cell_size;
    const double length = whole.norm();
    const auto count_of = [&](double margin) { return std::max(1, static_cast<int>(std::lround(length - 2.0 * margin))); };
    const double margin = count_of(ContactStencil::edge_margin) < fewest ? 0.0 : ContactStencil::edge_margin;
    const int count = count_of(margin);
    const Strips& strips = sides.emplace_back(Strips{static_cast<int>(points.size()), count, (length - 2.0 * margin) / count, margin});
    const auto add = [&](double from_edge, double width) {
      points.push_back({side.from / cell_size + from_edge / length * whole, side.normal, width});
    };
    if (margin > 0.0) add(0.5 * margin, margin);
    for (int i = 0; i < count; ++i) add(margin + (i + 0.5) * strips.width, strips.width);
    if (margin > 0.0) add(length - 0.5 * margin, margin);
    if (count < fewest) continue;
    const double end = margin + strips.width;
    const auto bound = [&](int number, int neighbour) {
      point(number).width = end;
      point(number).edge = {.neighbour = neighbour, .at_rest = end / strips.width, .free = free_ratio(end, strips.width)};
    };
    bound(strips.start(), strips.start() + 1);
    bound(strips.end(), strips.end() - 1);
  }
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const Strips &side = sides[s], &before = sides[(s + sides.size() - 1) % sides.size()], &after = sides[(s + 1) % sides.size()];
    point(side.start()).adjacent = before.end();
    point(side.end()).adjacent = after.start();
    if (side.margin == 0.0) continue;
    const auto compare = [&](SurfacePoint& in_margin, const Strips& other, int end) {
      in_margin.edge = {.neighbour = end, .at_rest = side.margin / other.width, .free = 0.0};
    };
    compare(point(side.start() - 1), before, before.end());
    compare(point(side.end() + 1), after, after.start());
  }
  return points;
}

/// Makes rows of points and nodes; with mirror planes, replaces points and nodes behind them by their images.
class StencilBuilder {
 public:
  /// @param circle  the outline, in cells; empty for a polygon
  StencilBuilder(const std::optional<Circle>& circle, const MirrorPlanes& mirror) : circle_(circle), mirror_(mirror) {}

  [[nodiscard]] bool computed(const Vec2& at) const {
    return (!mirror_.x || at.x() > -cell_rounding) && (!mirror_.y || at.y() > -cell_rounding);
  }
  /// The image of a position in the computed part.
  [[nodiscard]] Vec2 image(const Vec2& at) const { return {mirror_.x ? std::abs(at.x()) : at.x(), mirror_.y ? std::abs(at.y()) : at.y()}; }
  int node(int x, int y) {
    const auto [place, made] = number_.try_emplace({x, y}, static_cast<int>(stencil.nodes.size()));
    if (made) stencil.nodes.push_back({{x, y}, (mirror_.x && x == 0 ? 0.5 : 1.0) * (mirror_.y && y == 0 ? 0.5 : 1.0)});
    return place->second;
  }
  void begin(ContactRow::Kind kind, const Vec2& at, const Vec2& normal, double cell_size) {
    normal_ = normal;
    stencil.rows.push_back({.kind = kind, .first = stencil.entries.size(), .point = cell_size * at});
    if ((mirror_.x && std::abs(at.x()) < cell_rounding) || (mirror_.y && std::abs(at.y()) < cell_rounding))
      stencil.rows.back().computed = 0.5;
  }
  void add(int x, int y, double weight) {
    const Vec2 direction = direction_at(Vec2(x, y));
    Vec2 n = weight * direction, t = weight * Vec2(-direction.y(), direction.x());
    int at[2] = {x, y};
    for (int axis = 0; axis < 2; ++axis) {
      if (!mirror_.across(axis) || at[axis] > 0) continue;
      n[axis] = at[axis] == 0 ? 0.0 : -n[axis];  // on the plane material moves only along it
      t[axis] = at[axis] == 0 ? 0.0 : -t[axis];
      at[axis] = -at[axis];
    }
    const int number = node(at[0], at[1]);
    ContactRow& row = stencil.rows.back();
    for (std::size_t e = row.first; e < row.first + row.count; ++e) {
      ContactEntry& entry = stencil.entries[e];
      if (entry.node != number) continue;
      entry.normal += n;
      entry.tangent += t;
      entry.vertical += weight;
      return;
    }
    stencil.entries.push_back({number, n, t, weight});
    ++row.count;
  }
  ContactStencil stencil;

 private:
  /// Direction of the present row at a node: that of the row, or for a point on a circle that at the node's own position.
  [[nodiscard]] Vec2 direction_at(const Vec2& node) const {
    if (!circle_ || stencil.rows.back().kind != ContactRow::Kind::point) return normal_;
    const Vec2 from_centre = node - circle_->centre;
    const double radius = from_centre.norm();
    return radius > no_direction ? Vec2(from_centre / radius) : normal_;
  }

  std::optional<Circle> circle_;
  MirrorPlanes mirror_;
  Vec2 normal_;
  std::map<std::array<int, 2>, int> number_;
};

/// Integral of sqrt(s) over the strip of a column or layer, half a cell to both sides; s the distance from the edge. @param depth  cells
double root_law(double depth) { return std::pow(depth + 0.5, 1.5) - std::pow(std::max(0.0, depth - 0.5), 1.5); }

/// Grid nodes along x and y that hold the outline.
Eigen::AlignedBox2i nodes_around(const Outline& outline, double cell_size) {
  const Eigen::AlignedBox2d bounds = outline.bounds();
  return {(bounds.min() / cell_size).array().floor().cast<int>() - 1, (bounds.max() / cell_size).array().ceil().cast<int>() + 1};
}

/// The columns of a horizontal face.
void add_columns(StencilBuilder& builder, const Outline& outline, double cell_size, const Eigen::AlignedBox2i& nodes) {
  struct Place {
    std::array<int, 2> at;
    double depth;  ///< cells inside; negative outside
    Vec2 normal;   ///< outward, of the nearest side
  };
  std::vector<Place> places;
  for (int y = nodes.min().y(); y <= nodes.max().y(); ++y) {
    for (int x = nodes.min().x(); x <= nodes.max().x(); ++x) {
      const Outline::Nearest near = outline.nearest(cell_size * Vec2(x, y));
      const double depth = -near.distance / cell_size;
      if (builder.computed(Vec2(x, y)) && depth > cell_rounding - 0.5) places.push_back({{x, y}, depth, near.normal});
    }
  }
  std::ranges::stable_sort(places, std::ranges::greater{}, [](const Place& p) { return std::round(p.depth / cell_rounding); });
  std::vector<ContactStencil::Column>& columns = builder.stencil.columns;
  for (const Place& p : places) {
    columns.push_back({.node = builder.node(p.at[0], p.at[1])});
    if (p.depth > 0.5 + cell_rounding) continue;  // not the last column before an edge
    const Vec2 inwards = builder.image(Vec2(p.at[0] - std::round(p.normal.x()), p.at[1] - std::round(p.normal.y())));
    const std::array<int, 2> at = {static_cast<int>(inwards.x()), static_cast<int>(inwards.y())};
    const auto inner = std::ranges::find(places, at, &Place::at);
    if (inner == places.end() || inner->depth < p.depth + cell_rounding) continue;  // too narrow for an inner column
    columns.back().strip = (p.depth + 0.5) * cell_size;
    columns.back().edge = bound_by_depth(p.depth, inner->depth);
    columns.back().edge.neighbour = static_cast<int>(inner - places.begin());
  }
}

/// Rows of the points on the surface. @returns the row of each; -1 where it is not in the computed part
std::vector<int> add_point_rows(StencilBuilder& builder, const std::vector<SurfacePoint>& points, double cell_size) {
  std::vector<int> row_of(points.size(), -1);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const SurfacePoint& point = points[p];
    if (!builder.computed(point.at)) continue;
    row_of[p] = static_cast<int>(builder.stencil.rows.size());
    builder.begin(ContactRow::Kind::point, point.at, point.normal, cell_size);
    builder.stencil.rows.back().width = point.width * cell_size;
    const FixedWeights wx(point.at.x()), wy(point.at.y());
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (const double w = wx.w[i] * wy.w[j]; w > 1e-12) builder.add(wx.first + static_cast<int>(i), wy.first + static_cast<int>(j), w);
      }
    }
  }
  builder.stencil.point_rows = builder.stencil.rows.size();
  return row_of;
}

/// Which rows the last one before an edge refers to.
void link_rows(StencilBuilder& builder, const std::vector<SurfacePoint>& points, const std::vector<int>& row_of) {
  // of a point behind a mirror plane the row of its image: where an edge is on the plane, that of the point before the edge itself
  const auto row_or_image = [&](int point) {
    if (point < 0) return -1;
    if (const int row = row_of[static_cast<std::size_t>(point)]; row >= 0) return row;
    const Vec2 image = builder.image(points[static_cast<std::size_t>(point)].at);
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (row_of[p] >= 0 && (points[p].at - image).norm() < cell_rounding) return row_of[p];
    }
    return -1;
  };
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (row_of[p] < 0 || points[p].edge.neighbour < 0) continue;
    ContactRow& row = builder.stencil.rows[static_cast<std::size_t>(row_of[p])];
    row.edge = points[p].edge;
    row.edge.neighbour = row_or_image(points[p].edge.neighbour);
    row.adjacent = row_or_image(points[p].adjacent);
  }
}

/// Rows that extend velocities to nodes behind the surface, and the nodes deep inside.
void add_extensions(StencilBuilder& builder, const Outline& outline, const std::vector<SurfacePoint>& points,
                    const std::vector<int>& row_of, double cell_size, const Eigen::AlignedBox2i& nodes) {
  // of the rows of points the nearest whose normal is that of the place
  const auto row_before = [&](const Vec2& at, const Vec2& normal) {
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t p = 0; p < points.size(); ++p) {
      const double away = (points[p].at - at).norm() + (1.0 - points[p].normal.dot(normal)) / cell_rounding;
      if (row_of[p] >= 0 && away < least) least = away, best = row_of[p];
    }
    return best;
  };
  for (int y = nodes.min().y(); y <= nodes.max().y(); ++y) {
    for (int x = nodes.min().x(); x <= nodes.max().x(); ++x) {
      const Vec2 at(x, y);
      if (!builder.computed(at)) continue;
      const Outline::Nearest near = outline.nearest(cell_size * at);
      const double depth = -near.distance / cell_size;
      if (depth > ContactStencil::deep_from) builder.stencil.deep.push_back({builder.node(x, y), near.normal});
      const int axis = std::abs(near.normal.x()) >= std::abs(near.normal.y()) - cell_rounding ? 0 : 1;
      const double along_axis = depth / std::abs(near.normal[axis]);
      if (along_axis <= extended_from + cell_rounding || along_axis > extended_to) continue;
      if (outline.is_ambiguous(cell_size * at, ambiguous_distance * cell_size)) continue;
      const int outward = near.normal[axis] > 0.0 ? 1 : -1;
      builder.begin(ContactRow::Kind::extension, at, near.normal, cell_size);
      builder.stencil.rows.back().row_before = row_before(at, near.normal);
      for (int k = 0; k < 3; ++k) builder.add(x + (axis == 0 ? k * outward : 0), y + (axis == 1 ? k * outward : 0), k == 1 ? -2.0 : 1.0);
    }
  }
}

}  // namespace

EdgeBound bound_by_depth(double depth, double inner) {
  return {.at_rest = std::min(depth + 0.5, 1.0) / std::min(inner + 0.5, 1.0), .free = root_law(depth) / root_law(inner)};
}

ContactStencil contact_stencil(const Outline& outline, double cell_size, const MirrorPlanes& mirror) {
  std::optional<Circle> circle = outline.circle();
  if (circle) circle = Circle{.centre = circle->centre / cell_size, .radius = circle->radius / cell_size};
  StencilBuilder builder(circle, mirror);
  const std::vector<SurfacePoint> points = circle ? points_of_circle(*circle) : points_of_polygon(outline, cell_size);
  const Eigen::AlignedBox2i nodes = nodes_around(outline, cell_size);
  const std::vector<int> row_of = add_point_rows(builder, points, cell_size);
  link_rows(builder, points, row_of);
  add_extensions(builder, outline, points, row_of, cell_size, nodes);
  add_columns(builder, outline, cell_size, nodes);
  return std::move(builder.stencil);
}

}  // namespace mpm
