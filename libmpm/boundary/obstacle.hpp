#pragma once
/// Cross-section of an obstacle in plan, and its upstream surface.
///
/// Frame of every shape: the most upstream point at x = 0, the middle of its width at y = 0. The shapes: shapes/any_shape.hpp.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "libmpm/boundary/obstacle_spec.hpp"

namespace mpm {

/// A convex polygon or circle in plan, and distances from its front.
struct ObstaclePlan {
  std::vector<OutlineSide> sides;  ///< convex, counter-clockwise; of a circle: of a regular polygon inscribed in it
  std::optional<double> radius;    ///< m, of a circle with its centre at (radius, 0)
  double depth = 0.0;              ///< extent along x, from 0, m
  double width = 0.0;              ///< extent across, m
  bool symmetric = true;           ///< about y = 0
  bool flat_front = false;         ///< a rectangle with sides along the axes, as the paper's box: its front is the face x = 0

  /// x of the upstream surface at |y| <= width/2, m.
  [[nodiscard]] double front(double y) const;
  /// Distance of a point from that surface, m, for |y| <= width/2: positive upstream of it, negative inside and behind.
  [[nodiscard]] double front_distance(double x, double y) const;
  /// Unit normal, against the flow, of the point of the surface nearest to (x, y): the gradient of front_distance.
  [[nodiscard]] Vec2 front_normal(double x, double y) const;

 private:
  struct Nearest {
    double distance;
    Vec2 normal;
  };
  [[nodiscard]] Nearest nearest(double x, double y) const;
};

/// The plan of a shape with its width, depth and rotation.
[[nodiscard]] ObstaclePlan obstacle_plan(const ObstacleSpec& spec);

/// Point of the segment from `from` to `to` nearest to p.
[[nodiscard]] Vec2 nearest_point(const Vec2& from, const Vec2& to, const Vec2& p);

}  // namespace mpm
