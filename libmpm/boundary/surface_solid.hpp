#pragma once
/// Rigid solid that acts at its surface, not at the nodes: contact_stencil.hpp.

#include "libmpm/boundary/contact_stencil.hpp"
#include "libmpm/boundary/upright_solid.hpp"

namespace mpm {

/// A solid at rest: separable contact with Coulomb friction on all its faces.
class SurfaceSolid {
 public:
  /// @param reference  point about which the moment is taken, m
  /// @param cell_size  of the grid, m. @param mirror  planes at which only half of the domain is computed
  SurfaceSolid(UprightSolid solid, double friction, const Vec3& reference, double cell_size, MirrorPlanes mirror);

  [[nodiscard]] const ContactStencil& stencil() const { return stencil_; }  ///< its conditions, of every layer of nodes
  [[nodiscard]] const UprightSolid& solid() const { return solid_; }        ///< its geometry
  [[nodiscard]] double friction() const { return friction_; }               ///< mu

  /// What every boundary offers (any_boundary.hpp); it acts on nodes together. Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return reference_; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool covers(const Vec3& x, double) const { return solid_.nearest(x).distance <= on_surface; }
  void translate(const Vec3& by);
  /// @}

 private:
  UprightSolid solid_;
  double friction_;
  Vec3 reference_;
  double cell_size_;
  MirrorPlanes mirror_;
  ContactStencil stencil_;
};

}  // namespace mpm
