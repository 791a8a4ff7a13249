#include "libmpm/observe/pressure_profile.hpp"

#include <algorithm>

namespace mpm {

PressureProfile::PressureProfile(const ImpactGeometry& geometry)
    : geometry_(geometry), stress_(geometry.profile_bins(), 0.0), volume_(geometry.profile_bins(), 0.0) {}

std::vector<Column> PressureProfile::columns() const {
  return {{.quantity = "pressure_height",
           .unit = "m",
           .meaning = "height up to which the flow presses: where the smoothed pressure profile falls below 5 % of the impact pressure",
           .mean = true},
          {.quantity = "impact_pressure",
           .unit = "Pa",
           .meaning = "mean pressure on the obstacle over the flow height, from its foot",
           .mean = true},
          {.quantity = "compaction", .meaning = "density at the front face over the initial density", .mean = true}};
}

void PressureProfile::visit(const ParticleBatch& batch) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const ParticleView p = batch[i];
    if (!geometry_.in_profile_box(p.position)) continue;
    add(p.position, geometry_.normal_component(p.position, p.stress), geometry_.counted_ratio(p.volume_ratio(), p.mass), p.mass);
  }
}

void PressureProfile::add(const Vec3& position, double tau_nn, double J, double mass) {
  if (!geometry_.in_profile_box(position)) return;
  const double x = position[0] - geometry_.front(position[1]), z = position[2];
  const auto bin = std::min(static_cast<std::size_t>(std::max(z, 0.0) / geometry_.bin_height), stress_.size() - 1);
  stress_[bin] += tau_nn;
  volume_[bin] += J;
  if (z < geometry_.impact_top()) {
    stress_below_flow_height_ += tau_nn;
    volume_below_flow_height_ += J;
    if (x < 0.0) mass_ += mass;
  }
}

FrontPressure PressureProfile::finish() {
  const auto pressure = [](double stress, double volume) { return volume > 0.0 ? -stress / volume : 0.0; };
  FrontPressure now;
  now.impact_pressure = pressure(stress_below_flow_height_, volume_below_flow_height_);
  for (std::size_t bin = 0; bin < stress_.size(); ++bin) now.pressure.push_back(pressure(stress_[bin], volume_[bin]));
  now.pressure_height = pressure_height(now.pressure, now.impact_pressure, geometry_);
  const double box_volume = geometry_.box_area * (geometry_.impact_top() - geometry_.obstacle.foot());
  now.compaction = (geometry_.mirror_y ? 2.0 : 1.0) * mass_ / (box_volume * geometry_.density);

  stress_below_flow_height_ = volume_below_flow_height_ = mass_ = 0.0;
  std::ranges::fill(stress_, 0.0);
  std::ranges::fill(volume_, 0.0);
  return now;
}

void PressureProfile::sample(const Instant&, std::span<double> row) {
  const FrontPressure now = finish();
  row[0] = now.pressure_height.value_or(MeanEstimate::none);
  row[1] = now.impact_pressure;
  row[2] = now.compaction;
  over_time_.insert(over_time_.end(), now.pressure.begin(), now.pressure.end());
}

void PressureProfile::load(const Arrays& arrays, std::size_t samples) {
  over_time_ = stored_array(arrays, "pressure_pa", samples * geometry_.profile_bins());
}

PressureProfile::MeanProfile PressureProfile::mean_profile(const Summary& end) const {
  if (!end.span.steady) return {};
  MeanProfile mean;
  mean.pressure = end.mean_rows(over_time_, geometry_.profile_bins());
  mean.smoothed = savitzky_golay(mean.pressure, geometry_.filter_bins, geometry_.filter_order);
  for (std::size_t bin = 0; bin < mean.pressure.size(); ++bin) {
    const double low = geometry_.bin_height * static_cast<double>(bin);
    const auto below = [&](double z) { return std::clamp((z - low) / geometry_.bin_height, 0.0, 1.0); };
    const double covered = below(geometry_.obstacle.top) - below(geometry_.obstacle.base);
    mean.force_per_height.push_back(covered * mean.pressure[bin] * geometry_.obstacle_width);
  }
  return mean;
}

std::vector<Result> PressureProfile::summary(const Summary& end) const {
  double height = MeanEstimate::none, force = MeanEstimate::none;
  if (end.span.steady) {
    const MeanProfile mean = mean_profile(end);
    height = pressure_height(mean.pressure, end.mean("impact_pressure_pa").mean, geometry_).value_or(MeanEstimate::none);
    force = 0.0;
    for (const double f : mean.force_per_height) force += f * geometry_.bin_height;
  }
  return {{"pressure_height_peak_m", end.peak("pressure_height_m"), "m", "highest pressure height at any time"},
          {"pressure_height_of_mean_profile_m", height, "m", "pressure height of the time-mean profile"},
          {"profile_force_n", force, "N", "time-mean pressure profile integrated over the front, to compare with force_mean_n"}};
}

std::vector<HeightProfile> PressureProfile::profiles(const Summary& end) const {
  std::vector<double> centres;
  for (std::size_t bin = 0; bin < geometry_.profile_bins(); ++bin) centres.push_back(geometry_.bin_centre(bin));
  MeanProfile mean = mean_profile(end);
  return {
      {{.quantity = "z", .unit = "m", .meaning = "height of the bin's centre"}, centres, {}},
      {{.quantity = "pressure", .unit = "Pa", .meaning = "pressure on the front"}, std::move(mean.pressure), over_time_},
      {{.quantity = "smoothed_pressure", .unit = "Pa", .meaning = "pressure, smoothed by the filter that the pressure height uses"},
       std::move(mean.smoothed),
       {}},
      {{.quantity = "force_per_height", .unit = "N/m", .meaning = "pressure times the width of the obstacle, between its foot and its top"},
       std::move(mean.force_per_height),
       {}}};
}

}  // namespace mpm
