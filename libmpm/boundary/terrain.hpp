#pragma once
/// Uneven ground: the space below a height field.

#include <memory>

#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/height_field.hpp"

namespace mpm {

/// The ground below z = h(x, y), at rest or a belt that follows it.
///
/// With ContactRule::surface it acts on each column of nodes along z with the height and the normal that it has there
/// (core/folded_terrain.hpp); with ContactRule::nodal on each node below, with those at the node.
struct Terrain {
  /// Slope up to which a case may have ground: tan 30 degrees, beyond which columns along z are a poor approximation of the surface.
  static constexpr double steepest = 0.578;

  std::shared_ptr<const HeightField> field;  ///< in the frame of the case
  Contact contact = Contact::separable;      ///< of the surface
  double friction = 0.0;                     ///< mu
  double speed = 0.0;                        ///< m/s: the surface moves with speed (1, 0, dh/dx), tangent to the ground
  ContactRule rule = ContactRule::surface;   ///< where it acts
  Vec3 shift = Vec3::Zero();                 ///< m, of the field against the frame of the grid

  /// The surface above or below a point; heights in the frame of the grid. @param x  m
  [[nodiscard]] HeightField::Surface surface(const Vec3& x) const;
  /// Of the surface where its slope is `slope`, m/s.
  [[nodiscard]] Vec3 velocity(const Vec2& slope) const { return {speed, 0.0, speed * slope.x()}; }

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return shift; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3& x, double time) const;
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  void translate(const Vec3& by) { shift += by; }
  /// @}
};

}  // namespace mpm
