#include "libmpm/boundary/surface_solid.hpp"

#include <utility>

namespace mpm {

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
