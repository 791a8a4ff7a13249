#pragma once
/// Impulse of the material on a boundary in one step: exact sums over nodes.

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "libmpm/base/types.hpp"

namespace mpm {

/// Linear and angular impulse given by the material to the boundary, N s and N m s.
struct Impulse {
  Vec3 linear = Vec3::Zero();   ///< N s
  Vec3 angular = Vec3::Zero();  ///< about the boundary's reference point
  double work = 0.0;            ///< J: of the moving surface on the material, -linear . u summed over the nodes
  /// Adds an impulse at one point. @param given  by the material, N s. @param arm  from the reference point, m
  /// @param surface_velocity  there, m/s
  void add(const Vec3& given, const Vec3& arm, const Vec3& surface_velocity) {
    linear += given;
    work -= given.dot(surface_velocity);
    angular += arm.cross(given);
  }
  /// Adds the parts; both refer to the same reference point.
  Impulse& operator+=(const Impulse& other) {
    linear += other.linear;
    angular += other.angular;
    work += other.work;
    return *this;
  }
};

/// Impulses of one boundary by grid layer: nodes of one height. They add up to its Impulse::linear.
struct LayerImpulses {
  std::int32_t first = 0;   ///< number of the lowest layer: its nodes are at z = first dx
  std::vector<Vec3> layer;  ///< N s, from there upwards; empty: no impulse
};

}  // namespace mpm
