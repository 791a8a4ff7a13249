#pragma once
/// Rigid solid with vertical sides that acts at its surface, not at the nodes: contact_stencil.hpp.

#include <Eigen/Geometry>
#include <limits>
#include <optional>

#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/contact_stencil.hpp"
#include "libmpm/boundary/outline_distance.hpp"

namespace mpm {

/// A solid at rest: separable contact with Coulomb friction on its sides and on its top; it has no bottom, because it is on the floor.
class SurfaceSolid {
 public:
  /// Planes at which only half of the domain is computed.
  struct Mirrored {
    bool x = false;  ///< plane x = 0
    bool y = false;  ///< plane y = 0
  };
  /// @param top  m. @param reference  point about which the moment is taken, m
  /// @param cell_size  of the grid, m. @param mirrored  planes at which only half of the domain is computed
  SurfaceSolid(Outline outline, double top, double friction, const Vec3& reference, double cell_size, Mirrored mirrored);

  [[nodiscard]] const ContactStencil& stencil() const { return stencil_; }  ///< its conditions, of every layer of nodes
  [[nodiscard]] const Outline& outline() const { return outline_; }         ///< in plan, m
  [[nodiscard]] double top() const { return top_; }                         ///< m
  [[nodiscard]] double friction() const { return friction_; }               ///< mu

  /// The nearest place of the surface, for a place in the solid.
  struct Behind {
    double depth;  ///< m
    Vec3 normal;   ///< outward
  };
  /// How far a place is behind the surface; empty outside. @param x  m
  [[nodiscard]] std::optional<Behind> behind(const Vec3& x) const;
  /// Whether a part of a box may be in the solid. @param low, high  its corners, m
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high) const;

  /// What every boundary offers (any_boundary.hpp); it acts on nodes together. Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return reference_; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool covers(const Vec3& x, double time) const;
  [[nodiscard]] std::optional<Interval> section(double y) const { return outline_.section(y); }
  [[nodiscard]] Interval height() const { return {-std::numeric_limits<double>::infinity(), top_}; }
  void translate(const Vec3& by);
  /// @}

 private:
  Outline outline_;
  OutlineDistance distance_;
  Eigen::AlignedBox2d bounds_;  ///< of the outline
  double top_, friction_;
  Vec3 reference_;
  double cell_size_;
  Mirrored mirrored_;
  ContactStencil stencil_;
};

}  // namespace mpm
