#include "libmpm/boundary/solid.hpp"

#include <utility>

namespace mpm {

bool NodalSolid::reaches(const Vec3& low, const Vec3& high, double) const {
  const Vec3 reach = Vec3(skin, skin, 0.0) + Vec3::Constant(on_surface);
  return solid.bounds().intersects(Eigen::AlignedBox3d(low - reach, high + reach));
}

bool NodalSolid::covers(const Vec3& node, double time) const {
  return reaches(node, node, time) && solid.outline.distance(node.head<2>()) <= skin + on_surface;
}

Vec3 NodalSolid::constrain(const Vec3& node, const Vec3& v, double) const {
  return contact_velocity(v, solid.nearest(node).normal, Vec3::Zero(), contact, friction);
}

SurfaceSolid::SurfaceSolid(UprightSolid solid, double friction, const Vec3& reference, double cell_size, MirrorPlanes mirror)
    : solid_(std::move(solid)),
      friction_(friction),
      reference_(reference),
      cell_size_(cell_size),
      mirror_(mirror),
      stencil_(contact_stencil(solid_.outline, cell_size_, mirror_)) {}

void SurfaceSolid::translate(const Vec3& by) {
  solid_.translate(by);
  reference_ += by;
  stencil_ = contact_stencil(solid_.outline, cell_size_, mirror_);
}

}  // namespace mpm
