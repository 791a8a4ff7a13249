#pragma once
/// Plane walls: half-spaces at rest, moving, or with a surface that moves.

#include <functional>

#include "libmpm/boundary/contact.hpp"

namespace mpm {

/// Half-space behind a plane.
struct Wall {
  /// m, on the plane
  Vec3 point = Vec3::Zero();
  /// unit, into the material
  Vec3 normal = Vec3::UnitZ();
  /// of the surface
  Contact contact = Contact::no_slip;
  /// mu
  double friction = 0.0;
  Vec3 velocity = Vec3::Zero();           ///< of the surface, m/s
  bool travels = false;                   ///< the plane itself moves with `velocity`; false: a belt, or an inlet at a fixed place
  ContactRule rule = ContactRule::nodal;  ///< `surface` applies to walls normal to an axis; oblique walls are nodal

  /// Distance of the plane from the origin along its normal at some time, m.
  [[nodiscard]] double offset(double time) const { return point.dot(normal) + (travels ? time * velocity.dot(normal) : 0.0); }

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return point; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return velocity; }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  void translate(const Vec3& by) { point += by; }
  /// @}
};

/// Half-space at a fixed place whose surface moves along x, at a speed that varies with height and time: an inlet with a sheared
/// profile, a conveyor belt that speeds up.
struct MovingWall {
  Wall plane;                                               ///< its point is on the floor; its velocity is not used
  std::function<double(double height, double time)> speed;  ///< m/s, of the height over the plane's point (m) and the time (s)

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return plane.point; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3& node, double time) const { return {speed(node.z() - plane.point.z(), time), 0.0, 0.0}; }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const { return plane.reaches(low, high, time); }
  [[nodiscard]] bool covers(const Vec3& node, double time) const { return plane.covers(node, time); }
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  void translate(const Vec3& by) { plane.translate(by); }
  /// @}
};

}  // namespace mpm
