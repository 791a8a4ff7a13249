#pragma once
/// Cross-section of an obstacle in plan, as its shape gives it.

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace mpm {

using Vec2 = Eigen::Vector2d;  ///< x, y in plan, m

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
  /// Moves it in plan. @param by  m
  void translate(const Vec2& by) {
    for (Vec2& corner : corners) corner += by;
    if (circle) circle->centre += by;
  }
};

}  // namespace mpm
