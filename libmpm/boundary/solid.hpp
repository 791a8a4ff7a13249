#pragma once
/// Rigid solids at rest: what an obstacle is under the two rules of contact.

#include "libmpm/boundary/contact_stencil.hpp"
#include "libmpm/boundary/outline.hpp"

namespace mpm {

/// A solid that acts on each node by itself: a node in it obeys its nearest face, the one that it is least deep behind.
///
/// A node represents half a cell to each side, so a box whose faces are on grid planes acts half a cell wider. To treat inclined and
/// curved surfaces alike, nodes up to half a cell beside these (`skin`) belong to the solid. A cross-section must be about four cells wide
/// to be resolved.
struct NodalSolid {
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
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time) const;
  void translate(const Vec3& by) {
    solid.translate(by);
    reference += by;
  }
  /// @}
};

/// A solid that acts at its surface, on the nodes around it together (contact_stencil.hpp): separable contact with Coulomb friction on all
/// its faces.
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
  [[nodiscard]] bool covers(const Vec3& x, double) const { return solid_.distance(x) <= on_surface; }
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
