#pragma once
/// Cross-section of an obstacle in plan, as its shape gives it.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "libmpm/base/types.hpp"

namespace mpm {

/// How a shape meets the flow. How well a grid resolves the force depends on it: the numerical uncertainty of a run is looked up by it.
enum class Front : std::uint8_t {
  plane,  ///< plane faces, as those of a box
  round,  ///< curved
  edge,   ///< an edge against the flow between plane flanks
  other,  ///< none of these: the numerical uncertainty is not known
};

/// From low to high.
struct Interval {
  double low, high;  ///< m
};

/// A circle in plan.
struct Circle {
  Vec2 centre = Vec2::Zero();  ///< m
  double radius = 0.0;         ///< m
};

/// A side of a polygon.
struct OutlineSide {
  Vec2 from, to;  ///< m; the solid is to the left
  Vec2 normal;    ///< outward unit normal
};

/// The points x with n.x <= offset. A convex polygon is the intersection of those of its sides.
struct HalfPlane {
  Vec2 normal;    ///< outward unit normal n
  double offset;  ///< distance of its edge from the origin along n, m

  /// Signed distance from the edge, m; negative inside.
  [[nodiscard]] double distance(double x, double y) const { return normal.x() * x + normal.y() * y - offset; }
  /// Moves it in plan. @param by  m
  void translate(const Vec2& by) { offset += normal.x() * by.x() + normal.y() * by.y(); }
};

/// Part of the line y = const, along x, that lies in a solid; empty where they do not meet. @param y  m
/// @{
[[nodiscard]] inline std::optional<Interval> section(const Circle& circle, double y) {
  const double arm = y - circle.centre.y();
  if (std::abs(arm) >= circle.radius) return {};
  const double half = std::sqrt(circle.radius * circle.radius - arm * arm);
  return Interval{circle.centre.x() - half, circle.centre.x() + half};
}
[[nodiscard]] inline std::optional<Interval> section(std::span<const HalfPlane> sides, double y) {
  constexpr double parallel = 1e-9;  // x component of the normal of a side along x, from rounded angles
  Interval cut{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (const HalfPlane& side : sides) {
    const double n_x = side.normal.x(), end = -side.distance(0.0, y);  // n_x x <= end
    if (n_x < -parallel) cut.low = std::max(cut.low, end / n_x);
    if (n_x > parallel) cut.high = std::min(cut.high, end / n_x);
    if (std::abs(n_x) <= parallel && end < 0.0) return {};
  }
  return cut.low < cut.high ? std::optional(cut) : std::nullopt;
}
/// @}

/// A convex polygon. Frame of every shape: the most upstream point at x = 0, the middle of its width at y = 0.
struct Outline {
  std::vector<Vec2> corners;          ///< m, counter-clockwise; of a circle: of a regular polygon inscribed in it
  std::optional<Circle> circle = {};  ///< where it is one
  bool box = false;                   ///< a rectangle with sides along the axes, treated as the paper's box

  /// The sides of the polygon, counter-clockwise.
  [[nodiscard]] std::vector<OutlineSide> sides() const {
    std::vector<OutlineSide> all;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 &from = corners[i], &to = corners[(i + 1) % corners.size()];
      const Vec2 along = (to - from).normalized();
      all.push_back({from, to, Vec2(along.y(), -along.x())});
    }
    return all;
  }
  /// The half-planes of the sides, counter-clockwise.
  [[nodiscard]] std::vector<HalfPlane> half_planes() const {
    std::vector<HalfPlane> all;
    for (const OutlineSide& side : sides()) all.push_back({side.normal, side.normal.dot(side.from)});
    return all;
  }
  /// The smallest box that contains it, m.
  [[nodiscard]] Eigen::AlignedBox2d bounds() const {
    Eigen::AlignedBox2d all;
    for (const Vec2& corner : corners) all.extend(corner);
    if (circle) all.extend(Vec2(circle->centre.array() - circle->radius)).extend(Vec2(circle->centre.array() + circle->radius));
    return all;
  }
  /// Part of the line y = const in it. @param y  m
  [[nodiscard]] std::optional<Interval> section(double y) const {
    return circle ? mpm::section(*circle, y) : mpm::section(half_planes(), y);
  }
  /// Moves it in plan. @param by  m
  void translate(const Vec2& by) {
    for (Vec2& corner : corners) corner += by;
    if (circle) circle->centre += by;
  }
};

}  // namespace mpm
