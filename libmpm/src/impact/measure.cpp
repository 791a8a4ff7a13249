#include "mpm/impact/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mpm/error.hpp"
#include "mpm/impact/savitzky_golay.hpp"

namespace mpm {
namespace {

/// Percentile between order statistics (numpy's default, Hyndman and Fan's type 7); reorders the values.
double percentile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), below, values.end());
  const auto above = below + 1 == values.end() ? below : std::min_element(below + 1, values.end());
  return *below + (place - std::floor(place)) * (*above - *below);
}

}  // namespace

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
                          .profile_height = 5.0 * flow_height};
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
    throw ConfigError(fmt::format(
        "impact measurements: cell size {} m is too coarse for a flow height of {} m: the pressure profile has {} bins of {} m, its "
        "filter needs {}; use cells of at most {:.3g} m, or fix the windows in [measurement]",
        cell_size, flow_height, geometry.profile_bins(), geometry.bin_height, geometry.filter_bins,
        2.0 * geometry.profile_height / geometry.filter_bins));
  }
  return geometry;
}

ImpactGeometry fixed_geometry(double flow_height, double obstacle_width, double density, bool mirror_y) {
  constexpr double paper_cell_size = 0.25;
  return paper_geometry(flow_height, obstacle_width, paper_cell_size, density, mirror_y);
}

void ImpactGeometry::set_obstacle(const ObstacleSpec& spec) {
  obstacle_height = spec.height.value_or(std::numeric_limits<double>::infinity());
  if (has_flat_front(spec)) return;
  plan = obstacle_plan(spec);
  obstacle_width = plan->width;
  strip_half_width = 3.0 * obstacle_width / 7.0;
  // Area between the front and the line at box_upstream before it: in each of many strips along x, where that line is.
  constexpr int strips = 512, halvings = 40;  // of a length of some metres: the area is exact to the strips' width squared
  double mean_reach = 0.0;
  for (int i = 0; i < strips; ++i) {
    const double y = strip_half_width * (2.0 * (i + 0.5) / strips - 1.0), surface = front(y);
    double inside = surface, outside = surface - 2.0 * box_upstream;
    while (plan->front_distance(outside, y) < box_upstream) outside -= box_upstream;
    for (int n = 0; n < halvings; ++n) {
      const double middle = 0.5 * (inside + outside);
      (plan->front_distance(middle, y) < box_upstream ? inside : outside) = middle;
    }
    mean_reach += (surface - inside) / strips;
  }
  box_area = 2.0 * strip_half_width * mean_reach;
}

double ImpactGeometry::normal_component(const Vec3& position, const double (&stress)[6]) const {
  if (!plan) return stress[0];
  const Vec2 n = plan->front_normal(position[0], position[1]);
  return n.x() * n.x() * stress[0] + n.y() * n.y() * stress[1] + 2.0 * n.x() * n.y() * stress[3];
}

ImpactSample::ImpactSample(const ImpactGeometry& geometry)
    : geometry_(geometry), stress_(geometry.profile_bins(), 0.0), volume_(geometry.profile_bins(), 0.0) {}

void ImpactSample::add(const Vec3& position, double tau_nn, double J, double mass) {
  if (std::abs(position[1]) > geometry_.strip_half_width) return;
  const double x = position[0] - geometry_.front(position[1]), z = position[2];
  if (x < 0.0) {
    runup_ = std::max(runup_, z);
    if (x >= -geometry_.flow_height) near_heights_.push_back(z);
  }
  if (!geometry_.in_profile_box(position)) return;
  const auto bin = std::min(static_cast<std::size_t>(std::max(z, 0.0) / geometry_.bin_height), stress_.size() - 1);
  stress_[bin] += tau_nn;
  volume_[bin] += J;
  if (z < geometry_.impact_height()) {
    stress_below_flow_height_ += tau_nn;
    volume_below_flow_height_ += J;
    if (x < 0.0) mass_ += mass;
  }
}

ImpactFrame ImpactSample::finish() {
  const auto pressure = [](double stress, double volume) { return volume > 0.0 ? -stress / volume : 0.0; };
  ImpactFrame frame;
  frame.runup = runup_;
  frame.runup_p99 = percentile(near_heights_, 0.99);
  frame.impact_pressure = pressure(stress_below_flow_height_, volume_below_flow_height_);
  for (std::size_t bin = 0; bin < stress_.size(); ++bin) frame.pressure.push_back(pressure(stress_[bin], volume_[bin]));
  frame.pressure_height = pressure_height(frame.pressure, frame.impact_pressure, geometry_);
  const double box_volume = geometry_.box_area * geometry_.impact_height();
  frame.compaction = (geometry_.mirror_y ? 2.0 : 1.0) * mass_ / (box_volume * geometry_.density);

  runup_ = stress_below_flow_height_ = volume_below_flow_height_ = mass_ = 0.0;
  std::ranges::fill(stress_, 0.0);
  std::ranges::fill(volume_, 0.0);
  near_heights_.clear();
  return frame;
}

std::optional<double> pressure_height(std::span<const double> pressure, double impact_pressure, const ImpactGeometry& geometry) {
  if (!(impact_pressure > 0.0)) return std::nullopt;
  const double limit = geometry.threshold * impact_pressure;
  const auto smooth = savitzky_golay(pressure, geometry.filter_bins, geometry.filter_order);
  const auto above = std::ranges::find_if(smooth, [&](double p) { return p >= limit; });
  if (above == smooth.end()) return std::nullopt;
  const auto below = std::find_if(above, smooth.end(), [&](double p) { return p < limit; });
  if (below == smooth.end()) return geometry.profile_height;
  const double fall = *(below - 1) - *below;
  return geometry.bin_centre(static_cast<std::size_t>(below - 1 - smooth.begin())) + geometry.bin_height * (*(below - 1) - limit) / fall;
}

}  // namespace mpm
