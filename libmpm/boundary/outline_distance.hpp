#pragma once
/// Signed distance from an outline.

#include <algorithm>
#include <limits>
#include <vector>

#include "libmpm/boundary/shapes/outline.hpp"

namespace mpm {

/// Signed distance from a convex outline, negative inside.
class OutlineDistance {
 public:
  /// @param outline  m
  explicit OutlineDistance(const Outline& outline) : circle_(outline.circle) {
    if (circle_) return;
    for (const OutlineSide& side : outline.sides()) sides_.push_back({side.normal, side.normal.dot(side.from), side.from, side.to});
  }

  /// The nearest point of the outline.
  struct Nearest {
    double distance;  ///< m
    Vec2 normal;      ///< outward, of the nearest side
  };
  /// The distance at a place, and the normal there. Outside near a corner it is the distance from the lines of the sides, not from the
  /// corner: for what lies inside, or before one side. @param x  m
  [[nodiscard]] Nearest at(const Vec2& x) const {
    if (circle_) {
      const Vec2 arm = x - circle_->centre;
      const double r = arm.norm();
      return {r - circle_->radius, r > 1e-9 * circle_->radius ? Vec2(arm / r) : Vec2(-Vec2::UnitX())};  // upstream from the centre
    }
    Nearest nearest{-std::numeric_limits<double>::infinity(), -Vec2::UnitX()};
    for (const Side& side : sides_) {
      const double d = side.normal.dot(x) - side.offset, nearer = d - nearest.distance;
      // of several nearest sides the one further upstream, so that symmetric outlines give symmetric results
      if (nearer > as_near || (nearer > -as_near && side.normal.x() < nearest.normal.x())) nearest = {d, side.normal};
    }
    return nearest;
  }
  /// Distance of a point from the solid, m; 0 inside. Near a corner the distance from the corner.
  [[nodiscard]] double outside(const Vec2& x) const {
    if (circle_) return std::max(0.0, (x - circle_->centre).norm() - circle_->radius);
    double least = std::numeric_limits<double>::infinity();
    bool inside = true;
    for (const Side& side : sides_) {
      inside = inside && side.normal.dot(x) <= side.offset;
      const Vec2 along = side.to - side.from;
      const double nearest = std::clamp(along.dot(x - side.from) / along.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (x - side.from - nearest * along).norm());
    }
    return inside ? 0.0 : least;
  }
  /// Sides whose signed distance is above `distance`; 1 for a circle.
  [[nodiscard]] int sides_within(const Vec2& x, double distance) const {
    if (circle_) return 1;
    return static_cast<int>(
        std::count_if(sides_.begin(), sides_.end(), [&](const Side& s) { return s.normal.dot(x) - s.offset > distance; }));
  }

 private:
  static constexpr double as_near = 1e-9;  // m: distances are sums of rounded numbers
  struct Side {
    Vec2 normal;
    double offset;
    Vec2 from, to;
  };
  std::optional<Circle> circle_;
  std::vector<Side> sides_;
};

}  // namespace mpm
