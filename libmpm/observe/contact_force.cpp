#include "libmpm/observe/contact_force.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mpm {

namespace {

constexpr double none = MeanEstimate::none;

/// Mean over each value and the width - 1 before it; those before the first are zero.
std::vector<double> moving_mean(std::span<const double> values, std::size_t width) {
  std::vector<double> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto window = values.first(i + 1).last(std::min(width, i + 1));
    result.push_back(std::accumulate(window.begin(), window.end(), 0.0) / static_cast<double>(width));
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

/// Impulse between two times of a force given as means over the intervals before `time`. Of intervals cut by an end only the part inside
/// counts.
double impulse_between(double begin, double end, std::span<const double> time, std::span<const double> force) {
  double impulse = 0.0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    const double from = std::max(time[i - 1], begin), to = std::min(time[i], end);
    if (to > from && std::isfinite(force[i])) impulse += force[i] * (to - from);
  }
  return impulse;
}

}  // namespace

std::vector<double> overturning_moment(std::span<const double> moment_y, std::span<const double> force_z, double x) {
  std::vector<double> moment(moment_y.begin(), moment_y.end());
  for (std::size_t i = 0; i < moment.size(); ++i) moment[i] += x * force_z[i];
  return moment;
}

ForcePeaks force_peaks(std::span<const double> time, std::span<const double> force_x, std::span<const double> moment_y,
                       const ImpactFlow& flow, double window) {
  ForcePeaks result;
  const std::size_t n = time.size();
  if (n < 2) return result;
  result.interval = time[1] - time[0];
  const auto width = std::max<std::size_t>(1, static_cast<std::size_t>(window / result.interval + 1e-9));
  result.window = static_cast<double>(width) * result.interval;
  // at t = 0 there is no contact and no interval yet
  std::vector<double> force(force_x.begin(), force_x.end()), moment(moment_y.begin(), moment_y.end());
  force.front() = moment.front() = 0.0;

  const auto take = [&](const Peak& p, double mean_over, double& value, double& when) {
    value = p.value;
    if (p.value > 0.0) when = time[p.at] - 0.5 * mean_over;
  };
  take(peak_of(force), result.interval, result.peak, result.peak_time);
  take(peak_of(moment), result.interval, result.moment_peak, result.moment_peak_time);
  result.moment_filtered_peak = peak_of(moving_mean(moment, width)).value;
  const std::vector<double> filtered = moving_mean(force, width);
  const Peak top = peak_of(filtered);
  take(top, result.window, result.filtered_peak, result.filtered_peak_time);
  if (top.value > 0.0)
    result.rise_time = first_passage(time, filtered, 0.9 * top.value, top.at) - first_passage(time, filtered, 0.1 * top.value, top.at);
  const double fall = flow.arrival + (flow.gravity > 0.0 ? 2.0 * flow.velocity / flow.gravity : time.back());
  result.first_impact_until = std::min(fall, time.back());
  result.first_impact_impulse = impulse_between(flow.arrival, result.first_impact_until, time, force);
  return result;
}

std::vector<Result> TransientForce::summary(const Summary& end) const {
  const std::vector<double> moment = overturning_moment(end.series["moment_y_n_m"], end.series["force_z_n"], axis_);
  const ForcePeaks p = force_peaks(end.series.time(), end.series["force_x_n"], moment, flow_, window_);
  const double mean = end.mean("force_x_n").mean;
  const MeanEstimate steady_moment = end.mean(moment);
  return {
      {"force_interval_s", p.interval, "s", "sampling interval, over which raw peaks are means"},
      {"force_window_s", p.window, "s", "window of the moving mean behind filtered peaks: [measurement] force_window_s, to whole samples"},
      {"force_peak_n", p.peak, "N",
       "highest stream-wise force, mean over a sampling interval (an exact impulse); a peak at the first contact is caused by the "
       "vertical front with which every run starts and grows with series_per_second: not for design"},
      {"force_peak_time_s", p.peak_time, "s", "middle of the interval of that peak"},
      {"force_peak_to_mean", p.peak / mean, "", "that peak over the mean force"},
      {"force_filtered_peak_n", p.filtered_peak, "N", "highest stream-wise force, moving mean over the window"},
      {"force_filtered_peak_time_s", p.filtered_peak_time, "s", "middle of the window of that peak"},
      {"force_filtered_peak_to_mean", p.filtered_peak / mean, "", "that peak over the mean force"},
      {"force_rise_time_s", p.rise_time, "s", "time in which the filtered force rises from 10 to 90 % of its peak, first passages"},
      {"first_impact_until_s", p.first_impact_until, "s", "arrival + 2 v/g, when the first splash has fallen back, or the end of the run"},
      {"first_impact_impulse_n_s", p.first_impact_impulse, "N s", "stream-wise impulse from the arrival until then"},
      {"overturning_moment_axis_x_m", axis_, "m",
       "x of the mast's own axis; overturning moments are about the line along y that crosses it at the ground"},
      {"overturning_moment_mean_n_m", steady_moment.mean, "N m",
       "overturning moment about the mast's axis at its base, downstream positive; mean over the steady interval"},
      {"overturning_moment_standard_error_n_m", steady_moment.standard_error, "N m",
       "standard error of that mean, which accounts for autocorrelation", Nature::uncertainty},
      {"overturning_moment_peak_n_m", p.moment_peak, "N m", "highest overturning moment, mean over a sampling interval"},
      {"overturning_moment_peak_time_s", p.moment_peak_time, "s", "middle of the interval of that peak"},
      {"overturning_moment_filtered_peak_n_m", p.moment_filtered_peak, "N m", "highest overturning moment, moving mean over the window"}};
}

std::vector<Result> ArmLoads::summary(const Summary& end) const {
  const auto peaks = [&](const char* force) {
    return force_peaks(end.series.time(), end.series[force], end.series["arm_moment_y_n_m"], flow_, window_);
  };
  const ForcePeaks along = peaks("arm_force_x_n"), upwards = peaks("arm_force_z_n");
  const MeanEstimate moment = end.mean(overturning_moment(end.series["arm_moment_y_n_m"], end.series["arm_force_z_n"], axis_));
  return {{"arm_force_filtered_peak_n", along.filtered_peak, "N", "highest stream-wise force on the arm, moving mean over the window"},
          {"arm_force_filtered_peak_time_s", along.filtered_peak_time, "s", "middle of the window of that peak"},
          {"arm_force_z_filtered_peak_n", upwards.filtered_peak, "N", "highest upward force on the arm, moving mean over the window"},
          {"arm_force_z_filtered_peak_time_s", upwards.filtered_peak_time, "s", "middle of the window of that peak"},
          {"arm_overturning_moment_mean_n_m", moment.mean, "N m",
           "overturning moment of the arm about the mast's axis at its base, downstream positive; mean over the steady interval"},
          {"arm_overturning_moment_standard_error_n_m", moment.standard_error, "N m",
           "standard error of that mean, which accounts for autocorrelation", Nature::uncertainty}};
}

}  // namespace mpm
