#pragma once
/// Rigid box with faces along the axes.

#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/shapes/outline.hpp"

namespace mpm {

/// Rigid box at rest. A node inside is treated by the nearest face (an edge belongs to the upstream face first, then the
/// downstream one, the sides, the top): its normal points out of the box.
struct RigidBox {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< corners, m
  Contact contact = Contact::separable;         ///< of all faces
  double friction = 0.0;                        ///< mu
  Vec3 reference = Vec3::Zero();                ///< point about which the moment is taken

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return reference; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
  [[nodiscard]] std::optional<Interval> section(double y) const {
    return y < min.y() || y > max.y() ? std::nullopt : std::optional(Interval{min.x(), max.x()});
  }
  [[nodiscard]] Interval height() const { return {min.z(), max.z()}; }
  void translate(const Vec3& by) {
    min += by;
    max += by;
    reference += by;
  }
  /// @}
};

}  // namespace mpm
