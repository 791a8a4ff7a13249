#pragma once
/// Heights of uneven ground in plan, between the points of a raster.

#include <cmath>
#include <cstddef>
#include <vector>

#include "libmpm/base/types.hpp"

namespace mpm {

/// z = h(x, y), between regular points by Catmull-Rom's cubic along both axes (Keys 1981, IEEE Trans. Acoust. 29, with a = -1/2): h passes
/// through the points, its slope is continuous, planes are exact and so are quadratic surfaces away from the edge. Beyond the outermost
/// points it goes on with the slope of the nearest place that they span. Equal heights at all points give this height to the last bit.
class HeightField {
 public:
  /// The points.
  struct Points {
    Vec2 first = Vec2::Zero();          ///< m, of the south-western point: least x and y
    double spacing = 1.0;               ///< m, along both axes
    std::size_t columns = 2, rows = 2;  ///< along x and y, two or more of each
    std::vector<double> height = {};    ///< m, x fastest, from the south: columns * rows
    bool operator==(const Points&) const = default;
  };
  /// @param points  two or more along both axes; heights finite
  explicit HeightField(Points points);

  /// The surface above a place in plan.
  struct Surface {
    double height = 0.0;        ///< m
    Vec2 slope = Vec2::Zero();  ///< dh/dx, dh/dy
    /// Unit, upwards.
    [[nodiscard]] Vec3 normal() const { return Vec3(-slope.x(), -slope.y(), 1.0) / std::sqrt(1.0 + slope.squaredNorm()); }
  };
  [[nodiscard]] Surface at(const Vec2& place) const;  ///< @param place  m

  [[nodiscard]] const Points& points() const { return points_; }  ///< as given
  [[nodiscard]] Vec2 last() const;                                ///< m, the north-eastern point

  /// Bounds of h within the raster, m: the cubic leaves the range of its 16 points by at most 0.29 of it.
  /// @{
  [[nodiscard]] double lowest() const { return lowest_; }
  [[nodiscard]] double highest() const { return highest_; }
  /// @}

 private:
  Points points_;
  double lowest_, highest_;
};

}  // namespace mpm
