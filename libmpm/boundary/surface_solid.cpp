#include "libmpm/boundary/surface_solid.hpp"

#include <utility>

namespace mpm {

SurfaceSolid::SurfaceSolid(Outline outline, double top, double friction, const Vec3& reference, double cell_size, Mirrored mirrored)
    : outline_(std::move(outline)),
      distance_(outline_),
      bounds_(outline_.bounds()),
      top_(top),
      friction_(friction),
      reference_(reference),
      cell_size_(cell_size),
      mirrored_(mirrored),
      stencil_(contact_stencil(outline_, cell_size_, mirrored_.x, mirrored_.y)) {}

bool SurfaceSolid::covers(const Vec3& x, double) const {
  return x.z() <= top_ + on_surface && distance_.at(x.head<2>()).distance <= on_surface;
}

std::optional<SurfaceSolid::Behind> SurfaceSolid::behind(const Vec3& x) const {
  const double below = top_ - x.z();
  const OutlineDistance::Nearest side = distance_.at(x.head<2>());
  if (below <= 0.0 || side.distance >= 0.0) return std::nullopt;
  if (below < -side.distance) return Behind{below, Vec3::UnitZ()};
  return Behind{-side.distance, Vec3(side.normal.x(), side.normal.y(), 0.0)};
}

bool SurfaceSolid::reaches(const Vec3& low, const Vec3& high) const {
  return low.z() < top_ && bounds_.intersects(Eigen::AlignedBox2d(low.head<2>(), high.head<2>()));
}

void SurfaceSolid::translate(const Vec3& by) {
  outline_.translate(by.head<2>());
  distance_ = OutlineDistance(outline_);
  bounds_.translate(by.head<2>());
  top_ += by.z();
  reference_ += by;
  stencil_ = contact_stencil(outline_, cell_size_, mirrored_.x, mirrored_.y);
}

}  // namespace mpm
