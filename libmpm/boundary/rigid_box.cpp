#include "libmpm/boundary/rigid_box.hpp"

namespace mpm {

bool RigidBox::covers(const Vec3& node, double) const {
  return ((node - min).array() >= -on_surface).all() && ((max - node).array() >= -on_surface).all();
}

bool RigidBox::reaches(const Vec3& low, const Vec3& high, double) const {
  return ((high - min).array() >= -on_surface).all() && ((max - low).array() >= -on_surface).all();
}

Vec3 RigidBox::constrain(const Vec3& node, const Vec3& v, double) const {
  // depth below each face; the first of equals wins, so the order here is the order of precedence on edges
  struct Face {
    double depth;
    Vec3 normal;
  };
  const Face faces[] = {{node.x() - min.x(), -Vec3::UnitX()},
                        {max.x() - node.x(), Vec3::UnitX()},
                        {node.y() - min.y(), -Vec3::UnitY()},
                        {max.y() - node.y(), Vec3::UnitY()},
                        {max.z() - node.z(), Vec3::UnitZ()}};
  const Face* nearest = faces;
  for (const Face& face : faces) {
    if (face.depth < nearest->depth - on_surface) nearest = &face;
  }
  return contact_velocity(v, nearest->normal, Vec3::Zero(), contact, friction);
}

}  // namespace mpm
