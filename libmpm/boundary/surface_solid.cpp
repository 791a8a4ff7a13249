#include "libmpm/boundary/surface_solid.hpp"

#include <utility>

#include "libmpm/boundary/outline_distance.hpp"

namespace mpm {

SurfaceSolid::SurfaceSolid(Outline outline, double top, double friction, const Vec3& reference, double cell_size, Mirrored mirrored)
    : outline_(std::move(outline)), top_(top), friction_(friction), reference_(reference), cell_size_(cell_size), mirrored_(mirrored) {
  stencil_ = contact_stencil(outline_, cell_size_, mirrored_.x, mirrored_.y);
}

bool SurfaceSolid::covers(const Vec3& x, double) const {
  return x.z() <= top_ + on_surface && OutlineDistance(outline_).at(x.head<2>()).distance <= on_surface;
}

bool SurfaceSolid::reaches(const Vec3& low, const Vec3& high, double) const {
  Vec2 least = outline_.corners.front(), most = least;
  for (const Vec2& corner : outline_.corners) least = least.cwiseMin(corner), most = most.cwiseMax(corner);
  return low.z() <= top_ + on_surface && (low.head<2>().array() <= most.array() + on_surface).all() &&
         (high.head<2>().array() >= least.array() - on_surface).all();
}

void SurfaceSolid::translate(const Vec3& by) {
  outline_.translate(by.head<2>());
  top_ += by.z();
  reference_ += by;
  stencil_ = contact_stencil(outline_, cell_size_, mirrored_.x, mirrored_.y);
}

}  // namespace mpm
