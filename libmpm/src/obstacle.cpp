#include "mpm/obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mpm {

namespace {

constexpr int circle_sides = 256;  ///< the polygon is 7.5e-5 of the radius short of the circle

/// Point of a segment nearest to p.
Vec2 nearest_point(const Vec2& from, const Vec2& to, const Vec2& p) {
  const Vec2 along = to - from;
  return from + std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
}

std::vector<Vec2> corners_of(const ObstacleSpec& spec) {
  if (spec.shape == ObstacleSpec::Shape::wedge) {
    return {Vec2::Zero(), Vec2(spec.depth, -0.5 * spec.width), Vec2(spec.depth, 0.5 * spec.width)};
  }
  std::vector<Vec2> corners;
  if (spec.shape == ObstacleSpec::Shape::cylinder) {
    const double r = 0.5 * spec.width;
    for (int i = 0; i < circle_sides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / circle_sides;
      corners.emplace_back(r + r * std::cos(angle), r * std::sin(angle));
    }
    return corners;
  }
  const double c = std::cos(spec.rotation), s = std::sin(spec.rotation);
  const Vec2 along = 0.5 * spec.depth * Vec2(c, s), across = 0.5 * spec.width * Vec2(-s, c);
  for (const auto& [i, j] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) corners.emplace_back(i * along + j * across);
  double front = 0.0;
  for (const Vec2& corner : corners) front = std::min(front, corner.x());
  for (Vec2& corner : corners) corner.x() -= front;
  return corners;
}

}  // namespace

ObstaclePlan obstacle_plan(const ObstacleSpec& spec) {
  ObstaclePlan plan;
  const std::vector<Vec2> corners = corners_of(spec);
  double left = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &from = corners[i], &to = corners[(i + 1) % corners.size()];
    const Vec2 along = (to - from).normalized();
    plan.sides.push_back({from, to, Vec2(along.y(), -along.x())});
    plan.depth = std::max(plan.depth, from.x());
    left = std::max(left, from.y());
  }
  plan.width = 2.0 * left;  // every shape is centred
  if (spec.shape == ObstacleSpec::Shape::cylinder) plan.radius = 0.5 * spec.width;
  const double rounding = 1e-9 * plan.width;
  plan.symmetric = std::all_of(corners.begin(), corners.end(), [&](const Vec2& a) {
    return std::any_of(corners.begin(), corners.end(), [&](const Vec2& b) { return (Vec2(a.x(), -a.y()) - b).norm() <= rounding; });
  });
  return plan;
}

double ObstaclePlan::front(double y) const {
  if (radius) return *radius - std::sqrt(std::max(0.0, *radius * *radius - y * y));
  double x = 0.0;  // the furthest of the lines of the front sides, which are convex
  for (const Side& side : sides) {
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
  for (const Side& side : sides) {
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

bool has_flat_front(const ObstacleSpec& spec) { return spec.shape == ObstacleSpec::Shape::box && spec.rotation == 0.0; }

bool meets_obstacle(const BodySpec& body, const ObstacleSpec& obstacle) {
  const double top = obstacle.height.value_or(std::numeric_limits<double>::infinity());
  if (body.min.z() >= top || body.max.z() <= 0.0) return false;
  const ObstaclePlan plan = obstacle_plan(obstacle);
  // in coordinates in which the body's bounding box is the cube -1 .. 1; a map by axes keeps the plan convex
  const Vec3 centre = 0.5 * (body.min + body.max), half = 0.5 * (body.max - body.min);
  const auto mapped = [&](const Vec2& p) -> Vec2 { return (p - centre.head<2>()).cwiseQuotient(half.head<2>()); };
  double gap = std::numeric_limits<double>::infinity();  // of the body's axis from the plan
  bool within = true;
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& side : plan.sides) {
    const Vec2 from = mapped(side.from), to = mapped(side.to);
    within = within && (to - from).x() * -from.y() - (to - from).y() * -from.x() > 0.0;
    gap = std::min(gap, nearest_point(from, to, Vec2::Zero()).norm());
    low = low.cwiseMin(from);
    high = high.cwiseMax(from);
  }
  if ((low.array() >= 1.0).any() || (high.array() <= -1.0).any()) return false;
  if (body.shape == BodySpec::Shape::box) {
    // separating axes: those of the box were tried, these are the plan's sides
    return std::none_of(plan.sides.begin(), plan.sides.end(), [&](const auto& side) {
      const Vec2 from = mapped(side.from), along = mapped(side.to) - from, outward(along.y(), -along.x());
      return -outward.cwiseAbs().sum() - outward.dot(from) >= 0.0;
    });
  }
  if (within) gap = 0.0;
  const double above = std::clamp(centre.z(), 0.0, top) - centre.z();
  const double rise = body.shape == BodySpec::Shape::sphere ? above / half.z() : 0.0;
  return gap * gap + rise * rise < 1.0;
}

}  // namespace mpm
