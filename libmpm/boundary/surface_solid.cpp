#include "libmpm/boundary/surface_solid.hpp"

#include <utility>

namespace mpm {

SurfaceSolid::SurfaceSolid(Outline outline, double top, double friction, const Vec3& reference, double cell_size, Mirrored mirrored)
    : outline_(std::move(outline)),
      distance_(outline_),
      top_(top),
      friction_(friction),
      reference_(reference),
      cell_size_(cell_size),
      mirrored_(mirrored),
      stencil_(contact_stencil(outline_, cell_size_, mirrored_.x, mirrored_.y)) {}

bool SurfaceSolid::covers(const Vec3& x, double) const {
  return x.z() <= top_ + on_surface && distance_.at(x.head<2>()).distance <= on_surface;
}

void SurfaceSolid::translate(const Vec3& by) {
  outline_.translate(by.head<2>());
  distance_ = OutlineDistance(outline_);
  top_ += by.z();
  reference_ += by;
  stencil_ = contact_stencil(outline_, cell_size_, mirrored_.x, mirrored_.y);
}

}  // namespace mpm
