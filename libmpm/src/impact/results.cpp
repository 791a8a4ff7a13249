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
      s.compaction.size() != n || s.force.size() != n || s.moment.size() != n || s.profile_pressure.size() != n * s.profile_bins ||
      (!s.force_bins.empty() && (s.force_bins.size() != n * (s.profile_bins + 1) || s.force_first_moment.size() != n))) {
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

ForceByHeight force_by_height(std::span<const double> force, double lowest, double cell_size, const ImpactGeometry& geometry) {
  const std::size_t above = geometry.profile_bins();
  ForceByHeight result{std::vector<double>(above + 1, 0.0), 0.0};
  // share of what lies between two heights over the floor goes to each bin by the length that they have in common
  const auto spread = [&](double from, double to, double per_metre) {
    for (double low = from; low < to;) {
      const auto bin = std::min(static_cast<std::size_t>(low / geometry.bin_height), above);
      const double end = bin == above ? to : std::min(to, geometry.bin_height * static_cast<double>(bin + 1));
      if (end <= low) {  // rounding of low / bin_height
        low = std::nextafter(low, to);
        continue;
      }
      result.bins[bin] += per_metre * (end - low);
      low = end;
    }
  };
  for (std::size_t k = 0; k < force.size(); ++k) {
    const double z = lowest + static_cast<double>(k) * cell_size, low = z - 0.5 * cell_size, high = z + 0.5 * cell_size;
    result.first_moment += force[k] * z;
    if (force[k] == 0.0) continue;
    const double per_metre = force[k] / cell_size;
    spread(std::max(low, 0.0), std::max(high, 0.0), per_metre);
    if (low < 0.0) spread(std::max(-high, 0.0), -low, per_metre);
  }
  return result;
}

void ImpactSeries::append(double sample_time, const ImpactFrame& frame, const Vec3& mean_force, const Vec3& mean_moment,
                          const std::optional<ForceByHeight>& by_height) {
  if (time.empty()) profile_bins = frame.pressure.size();
  if (frame.pressure.size() != profile_bins) {
    throw ConfigError(
        fmt::format("impact series: a sample with {} pressure bins after samples with {}", frame.pressure.size(), profile_bins));
  }
  const bool booked = !force_first_moment.empty();
  if (!time.empty() && booked != by_height.has_value()) throw ConfigError("impact series: forces by height at some of the samples only");
  time.push_back(sample_time);
  runup.push_back(frame.runup);
  runup_p99.push_back(frame.runup_p99);
  pressure_height.push_back(frame.pressure_height.value_or(none));
  impact_pressure.push_back(frame.impact_pressure);
  compaction.push_back(frame.compaction);
  force.push_back(mean_force);
  moment.push_back(mean_moment);
  profile_pressure.insert(profile_pressure.end(), frame.pressure.begin(), frame.pressure.end());
  if (!by_height) return;
  if (by_height->bins.size() != profile_bins + 1) throw ConfigError("impact series: forces by height in other bins than the pressure");
  force_bins.insert(force_bins.end(), by_height->bins.begin(), by_height->bins.end());
  force_first_moment.push_back(by_height->first_moment);
}

namespace {

/// Highest finite value with its place; NaN without one.
struct Peak {
  double value = none;
  std::size_t at = 0;
};
Peak peak_of(std::span<const double> values) {
  Peak result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && !(result.value >= values[i])) result = {values[i], i};
  }
  return result;
}

/// Mean over `width` (odd) neighbours; before the first there was nothing; NaN where the last is within half a window.
std::vector<double> moving_mean(std::span<const double> values, std::size_t width) {
  std::vector<double> result(values.size(), none);
  const std::size_t half = width / 2;
  for (std::size_t i = 0; i + half < values.size(); ++i) {
    double sum = 0.0;
    for (std::size_t j = i < half ? 0 : i - half; j <= i + half; ++j) sum += values[j];
    result[i] = sum / static_cast<double>(width);
  }
  return result;
}

/// Time at which `values` first reach `level` at or before `last`, linear between samples.
double first_passage(std::span<const double> time, std::span<const double> values, double level, std::size_t last) {
  for (std::size_t i = 0; i <= last; ++i) {
    if (!(values[i] >= level)) continue;
    if (i == 0) return time[i];
    return time[i - 1] + (time[i] - time[i - 1]) * (level - values[i - 1]) / (values[i] - values[i - 1]);
  }
  return none;
}

}  // namespace

TransientForce transient_force(const ImpactSeries& series, const ImpactFlow& flow, double window) {
  TransientForce result;
  const std::size_t n = series.size();
  if (n < 2) return result;
  result.interval = series.time[1] - series.time[0];
  const auto half = static_cast<std::size_t>(0.5 * window / result.interval + 1e-9);
  const std::size_t width = 2 * half + 1;
  result.window = static_cast<double>(width) * result.interval;
  std::vector<double> middle(n), force(n), moment(n);
  for (std::size_t i = 0; i < n; ++i) {
    middle[i] = series.time[i] - 0.5 * result.interval;
    // at t = 0 nothing has touched yet, and no interval is behind
    force[i] = i == 0 ? 0.0 : series.force[i].x();
    moment[i] = i == 0 ? 0.0 : series.moment[i].y();
  }
  const auto told = [&](const Peak& p, double& value, double& time) {
    value = p.value;
    if (std::isfinite(p.value)) time = middle[p.at];
  };
  told(peak_of(force), result.peak, result.peak_time);
  told(peak_of(moment), result.moment_peak, result.moment_peak_time);
  result.moment_filtered_peak = peak_of(moving_mean(moment, width)).value;
  const std::vector<double> filtered = moving_mean(force, width);
  const Peak top = peak_of(filtered);
  told(top, result.filtered_peak, result.filtered_peak_time);
  if (top.value > 0.0) {
    result.rise_time = first_passage(middle, filtered, 0.9 * top.value, top.at) - first_passage(middle, filtered, 0.1 * top.value, top.at);
  }
  const double fall = flow.arrival + (flow.gravity > 0.0 ? 2.0 * flow.velocity / flow.gravity : series.time.back());
  result.first_impact_until = std::min(fall, series.time.back());
  double impulse = 0.0;
  for (std::size_t i = 1; i < n; ++i) {  // intervals that the end cuts count in part
    const double from = std::max(series.time[i - 1], flow.arrival), to = std::min(series.time[i], result.first_impact_until);
    if (to > from && std::isfinite(force[i])) impulse += force[i] * (to - from);
  }
  result.first_impact_impulse = impulse;
  return result;
}

namespace {

/// Force above a height of a mean force by height, N.
double force_above(double height, std::span<const double> bins, double bin_height) {
  double sum = bins.back();
  for (std::size_t bin = 0; bin + 1 < bins.size(); ++bin) {
    const double low = bin_height * static_cast<double>(bin);
    sum += bins[bin] * std::clamp((low + bin_height - height) / bin_height, 0.0, 1.0);
  }
  return sum;
}

/// Mean of columns of `width` values a sample over a span.
std::vector<double> mean_columns(const std::vector<double>& values, std::size_t width, const Steady& span) {
  std::vector<double> mean(width, 0.0);
  for (std::size_t sample = span.first; sample < span.last; ++sample) {
    for (std::size_t i = 0; i < width; ++i) mean[i] += values[sample * width + i];
  }
  for (double& m : mean) m /= static_cast<double>(span.last - span.first);
  return mean;
}

}  // namespace

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
  summary.transient = transient_force(series, flow, geometry.force_window);
  summary.force_by_height = !series.force_bins.empty();
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
  pressure.reserve(profile.size());
  for (const ProfileRow& row : profile) pressure.push_back(row.pressure);
  summary.pressure_height_of_mean_profile = pressure_height(pressure, summary.impact_pressure.mean, geometry).value_or(none);
  summary.profile_force = profile_force(profile, geometry);
  if (summary.force_by_height) {
    const auto bins = mean_columns(series.force_bins, series.profile_bins + 1, summary.span);
    if (std::isfinite(summary.pressure_height.mean))
      summary.force_above_pressure_height = force_above(summary.pressure_height.mean, bins, geometry.bin_height);
    summary.force_resultant_height = mean_columns(series.force_first_moment, 1, summary.span)[0] / summary.force[0].mean;
  }
  return summary;
}

std::vector<ProfileRow> mean_profile(const ImpactSeries& series, const Steady& span, const ImpactGeometry& geometry) {
  if (!span.steady) return {};
  const std::size_t bins = series.profile_bins;
  const std::vector<double> pressure = mean_columns(series.profile_pressure, bins, span);
  const std::vector<double> force = series.force_bins.empty() ? std::vector<double>() : mean_columns(series.force_bins, bins + 1, span);
  const auto smoothed = savitzky_golay(pressure, geometry.filter_bins, geometry.filter_order);
  std::vector<ProfileRow> rows;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    // share of the bin that is below the obstacle's top
    const double low = geometry.bin_height * static_cast<double>(bin);
    const double share = std::clamp((geometry.obstacle_height - low) / geometry.bin_height, 0.0, 1.0);
    rows.push_back({geometry.bin_centre(bin), pressure[bin], smoothed[bin], share * pressure[bin] * geometry.obstacle_width,
                    force.empty() ? none : force[bin] / geometry.bin_height});
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
  json["runup_peak_to_mean"] = s.runup_peak / s.runup.mean;
  put(json, "runup_p99", "_m", s.runup_p99);
  put(json, "pressure_height", "_m", s.pressure_height);
  json["pressure_height_peak_m"] = s.pressure_height_peak;
  json["pressure_height_of_mean_profile_m"] = s.pressure_height_of_mean_profile;
  put(json, "impact_pressure", "_pa", s.impact_pressure);
  put(json, "force", "_n", s.force);
  json["profile_force_n"] = s.profile_force;
  put(json, "moment", "_n_m", s.moment);
  if (s.force_by_height) {
    json["force_above_pressure_height_n"] = s.force_above_pressure_height;
    json["force_resultant_height_m"] = s.force_resultant_height;
  }
  if (s.transient) {
    const TransientForce& t = *s.transient;
    json["force_interval_s"] = t.interval;
    json["force_window_s"] = t.window;
    json["force_peak_n"] = t.peak;
    json["force_peak_time_s"] = t.peak_time;
    json["force_peak_to_mean"] = t.peak / s.force[0].mean;
    json["force_filtered_peak_n"] = t.filtered_peak;
    json["force_filtered_peak_time_s"] = t.filtered_peak_time;
    json["force_filtered_peak_to_mean"] = t.filtered_peak / s.force[0].mean;
    json["force_rise_time_s"] = t.rise_time;
    json["first_impact_until_s"] = t.first_impact_until;
    json["first_impact_impulse_n_s"] = t.first_impact_impulse;
    json["overturning_moment_peak_n_m"] = t.moment_peak;
    json["overturning_moment_peak_time_s"] = t.moment_peak_time;
    json["overturning_moment_filtered_peak_n_m"] = t.moment_filtered_peak;
  }
  put(json, "compaction", "", s.compaction);
  json["predicted_runup_m"] = s.predicted_runup;
  json["predicted_pressure_height_m"] = s.predicted_pressure_height;
  // NaN is not JSON: the serialiser writes null.
  return json.dump(2);
}

}  // namespace mpm
