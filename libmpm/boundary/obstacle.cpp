#include "libmpm/boundary/obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mpm {

Vec2 nearest_point(const Vec2& from, const Vec2& to, const Vec2& p) {
  const Vec2 along = to - from;
  return from + std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
}

ObstaclePlan obstacle_plan(const ObstacleSpec& spec) {
  ObstaclePlan plan;
  const Outline outline = outline_of(spec.shape);
  const std::vector<Vec2>& corners = outline.corners;
  plan.sides = outline.sides();
  double left = 0.0;
  for (const Vec2& corner : corners) {
    plan.depth = std::max(plan.depth, corner.x());
    left = std::max(left, corner.y());
  }
  plan.width = 2.0 * left;  // every shape is centred
  if (outline.circle) plan.radius = outline.circle->radius;
  plan.flat_front = outline.box;
  const double rounding = 1e-9 * plan.width;
  plan.symmetric = std::all_of(corners.begin(), corners.end(), [&](const Vec2& a) {
    return std::any_of(corners.begin(), corners.end(), [&](const Vec2& b) { return (Vec2(a.x(), -a.y()) - b).norm() <= rounding; });
  });
  return plan;
}

double ObstaclePlan::front(double y) const {
  if (radius) return *radius - std::sqrt(std::max(0.0, *radius * *radius - y * y));
  double x = 0.0;  // the furthest of the lines of the front sides, which are convex
  for (const OutlineSide& side : sides) {
    if (side.normal.x() < -1e-12) x = std::max(x, side.from.x() - side.normal.y() * (y - side.from.y()) / side.normal.x());
  }
  return x;
}

ObstaclePlan::Nearest ObstaclePlan::nearest(double x, double y) const {
  const bool upstream = x < front(y);
  const Vec2 p(x, y);
  if (radius) {
    const Vec2 arm = p - Vec2(*radius, 0.0);
    const double r = arm.norm();
    if (arm.x() >= 0.0) return {-*radius - arm.x(), -Vec2::UnitX()};  // in the downstream half, or behind
    return {r - *radius, arm / r};
  }
  Nearest result{upstream ? std::numeric_limits<double>::infinity() : -std::numeric_limits<double>::infinity(), -Vec2::UnitX()};
  for (const OutlineSide& side : sides) {
    if (side.normal.x() >= -1e-12) continue;
    if (upstream) {
      const Vec2 gap = p - nearest_point(side.from, side.to, p);
      const double distance = gap.norm();
      if (distance < result.distance) {
        const bool beside_corner = distance > 1e-9 * width && side.normal.dot(gap) < (1.0 - 1e-12) * distance;
        result = {distance, beside_corner ? Vec2(gap / distance) : side.normal};
      }
    } else if (const double depth_behind = side.normal.dot(p - side.from); depth_behind > result.distance) {
      result = {depth_behind, side.normal};
    }
  }
  return result;
}

double ObstaclePlan::front_distance(double x, double y) const { return nearest(x, y).distance; }
Vec2 ObstaclePlan::front_normal(double x, double y) const { return nearest(x, y).normal; }

}  // namespace mpm
