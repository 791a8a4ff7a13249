#pragma once
/// Rigid solids with vertical sides: prisms with a convex cross-section, circular cylinders.

#include <limits>
#include <vector>

#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/shapes/outline.hpp"

namespace mpm {

/// Common members of vertical solids of any cross-section.
///
/// A node represents half a cell to each side, so a box whose faces are on grid planes acts half a cell wider. To treat inclined and
/// curved surfaces alike, nodes up to half a cell outside the surface (`skin`) belong to the solid. A cross-section must be about four
/// cells wide to be resolved.
///
/// A node is treated by the nearest face: the one that it is least deep behind, or in the skin before. On the bisector of two sides
/// (a front edge on a mirror plane) the normal is their mean; the top counts only where it is nearer than every side.
struct VerticalSolid {
  double top = 0.0;                      ///< m; there is no bottom, because the solid is on the floor
  double skin = 0.0;                     ///< m, not on the top
  Contact contact = Contact::separable;  ///< of sides and top
  double friction = 0.0;                 ///< mu
  Vec3 reference = Vec3::Zero();         ///< point about which the moment is taken

  /// What every boundary offers (any_boundary.hpp), as far as the cross-section does not matter. Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return reference; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] Interval height() const { return {-std::numeric_limits<double>::infinity(), top}; }
  void translate(const Vec3& by) {
    top += by.z();
    reference += by;
  }
  /// @}
};

/// Convex prism at rest.
struct RigidPrism : VerticalSolid {
  std::vector<HalfPlane> sides;                               ///< three or more
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;  ///< of the plan, m; bounds the skin before a sharp edge, too

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  [[nodiscard]] std::optional<Interval> section(double y) const { return mpm::section(sides, y); }
  void translate(const Vec3& by);
  /// @}
};

/// Circular cylinder at rest; its axis is vertical.
struct RigidCylinder : VerticalSolid {
  Circle circle;  ///< in plan

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  [[nodiscard]] std::optional<Interval> section(double y) const { return mpm::section(circle, y); }
  void translate(const Vec3& by);
  /// @}
};

}  // namespace mpm
