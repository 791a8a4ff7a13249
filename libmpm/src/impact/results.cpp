#include "mpm/impact/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "mpm/error.hpp"
#include "mpm/impact/savitzky_golay.hpp"
#include "mpm/impact/semi_empirical.hpp"

namespace mpm {
namespace {

constexpr double none = MeanEstimate::none;

/// Largest finite value; NaN without one.
double peak(std::span<const double> values) {
  double result = none;
  for (const double v : values) {
    if (std::isfinite(v) && !(result >= v)) result = v;
  }
  return result;
}

std::array<MeanEstimate, 3> estimate_mean(std::span<const Vec3> vectors) {
  std::array<MeanEstimate, 3> result;
  std::vector<double> component(vectors.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(vectors, component.begin(), [axis](const Vec3& v) { return v[axis]; });
    result[static_cast<std::size_t>(axis)] = mpm::estimate_mean(component);
  }
  return result;
}

void require_equal_lengths(const ImpactSeries& s) {
  const std::size_t n = s.size();
  if (s.runup.size() != n || s.runup_p99.size() != n || s.pressure_height.size() != n || s.impact_pressure.size() != n ||
      s.compaction.size() != n || s.force.size() != n || s.moment.size() != n || s.profile_pressure.size() != n * s.profile_bins) {
    throw ConfigError(fmt::format("impact series: its columns are not all of the length of time, {} samples", n));
  }
}

void put(nlohmann::ordered_json& json, const std::string& name, const std::string& unit, const MeanEstimate& e) {
  json[name + "_mean" + unit] = e.mean;
  json[name + "_standard_error" + unit] = e.standard_error;
  json[name + "_effective_samples"] = e.effective_samples;
}

void put(nlohmann::ordered_json& json, const std::string& name, const std::string& unit, const std::array<MeanEstimate, 3>& e) {
  json[name + "_mean" + unit] = {e[0].mean, e[1].mean, e[2].mean};
  json[name + "_standard_error" + unit] = {e[0].standard_error, e[1].standard_error, e[2].standard_error};
  json[name + "_effective_samples"] = {e[0].effective_samples, e[1].effective_samples, e[2].effective_samples};
}

}  // namespace

void ImpactSeries::append(double sample_time, const ImpactFrame& frame, const Vec3& mean_force, const Vec3& mean_moment) {
  if (time.empty()) profile_bins = frame.pressure.size();
  if (frame.pressure.size() != profile_bins) {
    throw ConfigError(
        fmt::format("impact series: a sample with {} pressure bins after samples with {}", frame.pressure.size(), profile_bins));
  }
  time.push_back(sample_time);
  runup.push_back(frame.runup);
  runup_p99.push_back(frame.runup_p99);
  pressure_height.push_back(frame.pressure_height.value_or(none));
  impact_pressure.push_back(frame.impact_pressure);
  compaction.push_back(frame.compaction);
  force.push_back(mean_force);
  moment.push_back(mean_moment);
  profile_pressure.insert(profile_pressure.end(), frame.pressure.begin(), frame.pressure.end());
}

ImpactSummary summarise(const ImpactSeries& series, const ImpactGeometry& geometry, const ImpactFlow& flow) {
  require_equal_lengths(series);
  ImpactSummary summary;
  summary.runup_peak = peak(series.runup);
  summary.pressure_height_peak = peak(series.pressure_height);
  if (flow.effective_friction) {
    summary.predicted_runup = predicted_runup(*flow.effective_friction, flow.velocity, geometry.flow_height, flow.gravity);
    summary.predicted_pressure_height =
        predicted_pressure_height(*flow.effective_friction, flow.velocity, geometry.flow_height, flow.gravity);
  }
  if (series.size() == 0) return summary;
  summary.span =
      find_steady(series.time, series.runup, impact_steady_criteria(flow.arrival, flow.velocity, flow.gravity, series.time.back()));
  if (!summary.span.steady) return summary;

  const auto in_span = [&](const auto& column) {
    return std::span(column).subspan(summary.span.first, summary.span.last - summary.span.first);
  };
  summary.runup = mpm::estimate_mean(in_span(series.runup));
  summary.runup_p99 = mpm::estimate_mean(in_span(series.runup_p99));
  summary.pressure_height = mpm::estimate_mean(in_span(series.pressure_height));
  summary.impact_pressure = mpm::estimate_mean(in_span(series.impact_pressure));
  summary.compaction = mpm::estimate_mean(in_span(series.compaction));
  summary.force = estimate_mean(in_span(series.force));
  summary.moment = estimate_mean(in_span(series.moment));

  const auto profile = mean_profile(series, summary.span, geometry);
  std::vector<double> pressure;
  for (const ProfileRow& row : profile) pressure.push_back(row.pressure);
  summary.pressure_height_of_mean_profile = pressure_height(pressure, summary.impact_pressure.mean, geometry).value_or(none);
  summary.profile_force = profile_force(profile, geometry);
  return summary;
}

std::vector<ProfileRow> mean_profile(const ImpactSeries& series, const Steady& span, const ImpactGeometry& geometry) {
  if (!span.steady) return {};
  const std::size_t bins = series.profile_bins;
  std::vector<double> pressure(bins, 0.0);
  for (std::size_t sample = span.first; sample < span.last; ++sample) {
    for (std::size_t bin = 0; bin < bins; ++bin) pressure[bin] += series.profile_pressure[sample * bins + bin];
  }
  for (double& p : pressure) p /= static_cast<double>(span.last - span.first);
  const auto smoothed = savitzky_golay(pressure, geometry.filter_bins, geometry.filter_order);
  std::vector<ProfileRow> rows;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    rows.push_back({geometry.bin_centre(bin), pressure[bin], smoothed[bin], pressure[bin] * geometry.obstacle_width});
  }
  return rows;
}

double profile_force(const std::vector<ProfileRow>& profile, const ImpactGeometry& geometry) {
  double force = 0.0;
  for (const ProfileRow& row : profile) force += row.force_per_height * geometry.bin_height;
  return force;
}

std::string to_json(const ImpactSummary& s) {
  nlohmann::ordered_json json;
  json["steady"] = s.span.steady;
  json["steady_from_s"] = s.span.steady ? s.span.from : none;
  json["steady_to_s"] = s.span.steady ? s.span.to : none;
  json["steady_samples"] = s.span.last - s.span.first;
  put(json, "runup", "_m", s.runup);
  json["runup_peak_m"] = s.runup_peak;
  put(json, "runup_p99", "_m", s.runup_p99);
  put(json, "pressure_height", "_m", s.pressure_height);
  json["pressure_height_peak_m"] = s.pressure_height_peak;
  json["pressure_height_of_mean_profile_m"] = s.pressure_height_of_mean_profile;
  put(json, "impact_pressure", "_pa", s.impact_pressure);
  put(json, "force", "_n", s.force);
  json["profile_force_n"] = s.profile_force;
  put(json, "moment", "_n_m", s.moment);
  put(json, "compaction", "", s.compaction);
  json["predicted_runup_m"] = s.predicted_runup;
  json["predicted_pressure_height_m"] = s.predicted_pressure_height;
  // NaN is not JSON: the serialiser writes null.
  return json.dump(2);
}

}  // namespace mpm
