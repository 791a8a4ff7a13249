#include "libmpm/boundary/rigid_solid.hpp"

namespace mpm {

bool RigidSolid::reaches(const Vec3& low, const Vec3& high, double) const {
  const Vec3 reach = Vec3(skin, skin, 0.0) + Vec3::Constant(on_surface);
  return solid.bounds().intersects(Eigen::AlignedBox3d(low - reach, high + reach));
}

bool RigidSolid::covers(const Vec3& node, double time) const {
  return reaches(node, node, time) && solid.outline.nearest(node.head<2>()).distance <= skin + on_surface;
}

Vec3 RigidSolid::constrain(const Vec3& node, const Vec3& v, double) const {
  return contact_velocity(v, solid.nearest(node).normal, Vec3::Zero(), contact, friction);
}

}  // namespace mpm
