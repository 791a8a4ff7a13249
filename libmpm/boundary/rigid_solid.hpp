#pragma once
/// Rigid solid that acts on each node by itself.

#include "libmpm/boundary/upright_solid.hpp"

namespace mpm {

/// A solid at rest. A node in it obeys its nearest face, the one that it is least deep behind.
///
/// A node represents half a cell to each side, so a box whose faces are on grid planes acts half a cell wider. To treat inclined and
/// curved surfaces alike, nodes up to half a cell beside these (`skin`) belong to the solid. A cross-section must be about four cells wide
/// to be resolved.
struct RigidSolid {
  UprightSolid solid;                    ///< its geometry
  double skin = 0.0;                     ///< m, in plan; not on top and underside
  Contact contact = Contact::separable;  ///< of all faces
  double friction = 0.0;                 ///< mu
  Vec3 reference = Vec3::Zero();         ///< point about which the moment is taken

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return reference; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  void translate(const Vec3& by) {
    solid.translate(by);
    reference += by;
  }
  /// @}
};

}  // namespace mpm
