#include "libmpm/impact/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "libmpm/base/error.hpp"

namespace mpm {

namespace {

/// Orthonormal polynomials of degree 0..order on `window` equally spaced points, one row each: Gram's polynomials, by orthogonalising
/// x times the previous one against all before it (twice, which is enough for round-off).
std::vector<std::vector<double>> orthonormal_polynomials(int window, int order) {
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const double half = 0.5 * (window - 1);
  std::vector<std::vector<double>> basis;
  std::vector<double> next(static_cast<std::size_t>(window), 1.0);
  for (int degree = 0; degree <= order; ++degree) {
    for (int pass = 0; pass < 2; ++pass) {
      for (const auto& b : basis) {
        const double component = dot(b, next);
        for (std::size_t i = 0; i < next.size(); ++i) next[i] -= component * b[i];
      }
    }
    const double norm = std::sqrt(dot(next, next));
    for (double& value : next) value /= norm;
    basis.push_back(next);
    for (std::size_t i = 0; i < next.size(); ++i) next[i] *= static_cast<double>(i) - half;
  }
  return basis;
}

}  // namespace

std::vector<double> savitzky_golay(std::span<const double> values, int window, int order) {
  const int n = static_cast<int>(values.size());
  if (window < 1 || window % 2 == 0 || order < 0 || order >= window || window > n) {
    throw ConfigError(
        fmt::format("savitzky_golay: window {}, order {} for {} values: the window must be odd, greater than the order and at "
                    "most the number of values",
                    window, order, n));
  }
  const auto basis = orthonormal_polynomials(window, order);
  std::vector<double> smooth(values.size(), 0.0);
  for (int i = 0; i < n; ++i) {
    const int first = std::clamp(i - window / 2, 0, n - window);
    const auto around = values.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(window));
    for (const auto& b : basis) {
      smooth[static_cast<std::size_t>(i)] +=
          std::inner_product(b.begin(), b.end(), around.begin(), 0.0) * b[static_cast<std::size_t>(i - first)];
    }
  }
  return smooth;
}

std::size_t ImpactGeometry::profile_bins() const {
  // A height of a whole number of bins, up to rounding, has that number of bins.
  return static_cast<std::size_t>(std::ceil(profile_height / bin_height * (1.0 - 1e-12)));
}

ImpactGeometry paper_geometry(double flow_height, double obstacle_width, double cell_size, double density, bool mirror_y,
                              const MeasurementSpec& windows) {
  const auto require_positive = [](const char* name, double value) {
    if (!(value > 0.0) || !std::isfinite(value))
      throw ConfigError(fmt::format("impact measurements: {} = {}: must be positive", name, value));
  };
  require_positive("flow height (m)", flow_height);
  require_positive("obstacle width (m)", obstacle_width);
  require_positive("cell size (m)", cell_size);
  require_positive("density (kg/m^3)", density);
  ImpactGeometry geometry{.flow_height = flow_height,
                          .obstacle_width = obstacle_width,
                          .density = density,
                          .mirror_y = mirror_y,
                          .strip_half_width = 3.0 * obstacle_width / 7.0,
                          .box_upstream = windows.box_upstream.value_or(2.5 * cell_size),
                          .box_inside = windows.box_inside.value_or(0.5 * cell_size),
                          .bin_height = windows.bin_height.value_or(0.5 * cell_size),
                          .profile_height = 5.0 * flow_height,
                          .cell_volume = cell_size * cell_size * cell_size,
                          .obstacle = {BoxShape{.width = obstacle_width}.outline()}};
  geometry.force_window = windows.force_window;
  geometry.box_area = 2.0 * geometry.strip_half_width * geometry.box_upstream;
  require_positive("box depth (m)", geometry.box_upstream);
  require_positive("bin height (m)", geometry.bin_height);
  if (windows.filter_length) {
    geometry.filter_bins = static_cast<int>(std::lround(*windows.filter_length / geometry.bin_height));
    if (geometry.filter_bins % 2 == 0 || geometry.filter_bins <= geometry.filter_order) {
      throw ConfigError(fmt::format("impact measurements: a filter of {} m over bins of {} m is {} bins; give an odd number, at least {}",
                                    *windows.filter_length, geometry.bin_height, geometry.filter_bins, geometry.filter_order + 1));
    }
  }
  if (geometry.profile_bins() < static_cast<std::size_t>(geometry.filter_bins)) {
    throw ConfigError(
        fmt::format("is too large for a flow height of {} m: the pressure profile has {} bins of {} m, its filter needs {}; give {} of at "
                    "most {:.3g} m",
                    flow_height, geometry.profile_bins(), geometry.bin_height, geometry.filter_bins, windows.bin_height ? "bins" : "cells",
                    (windows.bin_height ? 1.0 : 2.0) * geometry.profile_height / geometry.filter_bins));
  }
  return geometry;
}

namespace {

/// Distance along x, upstream of the front at y, of the points whose distance from the front is `distance`, m.
double reach_upstream(const Outline& outline, double y, double distance) {
  const auto section = outline.section(y);
  if (!section) throw ConfigError("is no cell size for so narrow an obstacle; give one of at most its width");
  const double surface = section->low;
  const auto excess = [&](double x) { return outline.nearest_of_front({x, y}).distance - distance; };
  double outside = surface - 2.0 * distance;
  while (excess(outside) < 0.0) outside -= distance;
  std::uintmax_t iterations = 100;
  const auto root = boost::math::tools::toms748_solve(excess, outside, surface, boost::math::tools::eps_tolerance<double>(), iterations);
  return surface - 0.5 * (root.first + root.second);
}

}  // namespace

void ImpactGeometry::set_obstacle(const ObstacleSpec& spec) {
  obstacle = spec.solid();
  if (obstacle.outline.along_axes()) return;
  obstacle_width = obstacle.outline.bounds().sizes().y();
  strip_half_width = 3.0 * obstacle_width / 7.0;
  // Area between the front and the line at box_upstream before it: sum of many strips along x.
  constexpr int strips = 512;  // the area is exact to the strips' width squared
  double mean_reach = 0.0;
  for (int i = 0; i < strips; ++i) {
    const double y = strip_half_width * (2.0 * (i + 0.5) / strips - 1.0);
    mean_reach += reach_upstream(obstacle.outline, y, box_upstream) / strips;
  }
  box_area = 2.0 * strip_half_width * mean_reach;
}

double ImpactGeometry::normal_component(const Vec3& position, std::span<const double, 6> stress) const {
  const Vec2 n = obstacle.outline.nearest_of_front(position.head<2>()).normal;
  return n.x() * n.x() * stress[0] + n.y() * n.y() * stress[1] + 2.0 * n.x() * n.y() * stress[3];
}

std::optional<double> pressure_height(std::span<const double> pressure, double impact_pressure, const ImpactGeometry& geometry) {
  if (!(impact_pressure > 0.0)) return std::nullopt;
  const double limit = geometry.threshold * impact_pressure;
  const auto smooth = savitzky_golay(pressure, geometry.filter_bins, geometry.filter_order);
  const auto above = std::ranges::find_if(smooth, [&](double p) { return p >= limit; });
  if (above == smooth.end()) return std::nullopt;
  const auto below = std::find_if(above, smooth.end(), [&](double p) { return p < limit; });
  const double highest = std::min(geometry.profile_height, geometry.obstacle.top);
  if (below == smooth.end()) return highest;
  const double fall = *(below - 1) - *below, lower = geometry.bin_centre(static_cast<std::size_t>(below - 1 - smooth.begin()));
  return std::min(highest, lower + geometry.bin_height * (*(below - 1) - limit) / fall);
}

}  // namespace mpm
