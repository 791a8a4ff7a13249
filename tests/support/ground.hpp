#pragma once
/// Uneven ground for tests.

#include <cmath>
#include <memory>

#include "libmpm/boundary/terrain.hpp"
#include "libmpm/driver/terrain_raster.hpp"

namespace mpm::testing {

/// Points of a function h(x, y) over a square around the origin.
template <class F>
HeightField::Points ground_points(F&& h, double half_width, double spacing) {
  const auto count = static_cast<std::size_t>(std::lround(2.0 * half_width / spacing)) + 1;
  HeightField::Points points{.first = Vec2::Constant(-half_width), .spacing = spacing, .columns = count, .rows = count, .height = {}};
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t i = 0; i < count; ++i)
      points.height.push_back(h(-half_width + static_cast<double>(i) * spacing, -half_width + static_cast<double>(j) * spacing));
  }
  return points;
}

/// The same as a field.
template <class F>
std::shared_ptr<const HeightField> ground_field(F&& h, double half_width = 8.0, double spacing = 1.0) {
  return std::make_shared<const HeightField>(ground_points(h, half_width, spacing));
}

/// The same for a case.
template <class F>
TerrainSpec ground_spec(F&& h, double half_width, double spacing) {
  TerrainSpec spec;
  spec.raster = raster_text(ground_points(h, half_width, spacing));
  return spec;
}

}  // namespace mpm::testing
