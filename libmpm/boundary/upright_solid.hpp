#pragma once
/// The geometry of every obstacle: an outline in plan between two heights.

#include <algorithm>
#include <limits>

#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/outline.hpp"

namespace mpm {

/// A solid with vertical sides; what stands on the ground has no underside, what no jet reaches has no top.
struct UprightSolid {
  Outline outline;                                         ///< in plan
  double base = -std::numeric_limits<double>::infinity();  ///< m, of the underside
  double top = std::numeric_limits<double>::infinity();    ///< m

  /// The nearest place of the surface.
  struct Nearest {
    double distance;  ///< m, negative inside; before an edge of the top or of the underside the larger of the distances along z and in plan
    Vec3 normal;      ///< outward, of the nearest face; a side where a side and another face are equally near
  };
  /// @param x  m
  [[nodiscard]] Nearest nearest(const Vec3& x) const {
    const Outline::Nearest side = outline.nearest(x.head<2>());
    if (const double face = beyond(x.z()); face > side.distance + on_surface)
      return {face, x.z() - top >= base - x.z() ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitZ())};
    return {side.distance, Vec3(side.normal.x(), side.normal.y(), 0.0)};
  }
  /// Of the surface, m; negative inside; before an edge as in Nearest. @param x  m
  [[nodiscard]] double distance(const Vec3& x) const { return std::max(outline.distance(x.head<2>()), beyond(x.z())); }
  /// Height over the top or below the underside, m; negative between them. @param z  m
  [[nodiscard]] double beyond(double z) const { return std::max(z - top, base - z); }
  /// Of the underside, or of the ground that it stands on, m.
  [[nodiscard]] double foot() const { return std::max(base, 0.0); }
  /// The smallest box that contains it, m.
  [[nodiscard]] Eigen::AlignedBox3d bounds() const {
    const Eigen::AlignedBox2d plan = outline.bounds();
    return {Vec3(plan.min().x(), plan.min().y(), base), Vec3(plan.max().x(), plan.max().y(), top)};
  }
  /// Moves it. @param by  m
  void translate(const Vec3& by) {
    outline.translate(by.head<2>());
    base += by.z();
    top += by.z();
  }
};

}  // namespace mpm
