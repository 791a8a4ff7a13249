#include "libmpm/boundary/terrain.hpp"

namespace mpm {

HeightField::Surface Terrain::surface(const Vec3& x) const {
  HeightField::Surface found = field->at(x.head<2>() - shift.head<2>());
  found.height += shift.z();
  return found;
}

Vec3 Terrain::surface_velocity(const Vec3& x, double) const { return speed == 0.0 ? Vec3(Vec3::Zero()) : velocity(surface(x).slope); }

bool Terrain::reaches(const Vec3& low, const Vec3& high, double) const {
  // beyond the raster the ground may rise above its highest point: there each node is asked
  const Vec2 from = field->points().first + shift.head<2>(), to = field->last() + shift.head<2>();
  const bool within = low.x() >= from.x() && low.y() >= from.y() && high.x() <= to.x() && high.y() <= to.y();
  return !within || low.z() <= field->highest() + shift.z() + on_surface;
}

bool Terrain::covers(const Vec3& node, double) const { return node.z() - surface(node).height <= on_surface; }

Vec3 Terrain::constrain(const Vec3& node, const Vec3& v, double) const {
  const HeightField::Surface here = surface(node);
  return contact_velocity(v, here.normal(), velocity(here.slope), contact, friction);
}

}  // namespace mpm
