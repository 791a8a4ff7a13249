#include "libmpm/impact/stop_rule.hpp"

#include <algorithm>
#include <cmath>

#include "libmpm/impact/steady.hpp"

namespace mpm {

namespace {

/// Number of the last check at or before a time; -1 before the first.
double check_number(const StopRule& rule, double time) {
  return time < rule.first_check ? -1.0 : std::floor((time - rule.first_check) / rule.check_interval);
}

/// Whether a sample is the first at or after a check.
bool is_check(const StopRule& rule, std::span<const double> time, std::size_t sample) {
  return check_number(rule, time[sample]) > (sample == 0 ? -1.0 : check_number(rule, time[sample - 1]));
}

bool is_known(std::span<const double> values, const StopRule& rule) {
  const MeanEstimate all = estimate_mean(values);
  const std::size_t half = values.size() / 2;
  const double drift = estimate_mean(values.subspan(half)).mean - estimate_mean(values.first(half)).mean;
  const double allowed = rule.standard_error * std::abs(all.mean);  // NaN, an unknown mean or error, is never below it
  const double highest_error = all.standard_error * (1.0 + std::sqrt(2.0 / (all.effective_samples - 1.0)));
  return highest_error <= allowed && std::abs(drift) <= allowed;
}

/// Whether the rule holds with these samples alone.
bool holds(std::span<const double> time, std::span<const double> runup, std::span<const std::span<const double>> others,
           const StopRule& rule) {
  const std::size_t n = time.size();
  const Steady span =
      find_steady(time, runup, impact_steady_criteria(rule.flow.arrival, rule.flow.velocity, rule.flow.gravity, time.back()));
  const auto known = [&](std::span<const double> values) {
    return is_known(values.first(n).subspan(span.first, span.last - span.first), rule);
  };
  return span.steady && known(runup) && std::ranges::all_of(others, known);
}

}  // namespace

StopRule impact_stop_rule(double standard_error, const ImpactFlow& flow, double flow_height, double passage) {
  StopRule rule{.flow = flow, .standard_error = standard_error};
  const double rise = flow.velocity / flow.gravity;
  rule.first_check = flow.arrival + std::max(3.0 * rise, passage / flow.velocity);
  rule.check_interval = std::max(rise, flow_height / flow.velocity);
  return rule;
}

bool may_end(std::span<const double> time, std::span<const double> runup, std::span<const std::span<const double>> others,
             const StopRule& rule) {
  if (rule.standard_error == 0.0 || time.empty() || !is_check(rule, time, time.size() - 1)) return false;
  if (check_number(rule, time.back()) + 1.0 < rule.checks) return false;
  int held = 0;
  for (std::size_t n = time.size(); n > 0 && held < rule.checks; --n) {  // the last check first: most often it decides
    if (!is_check(rule, time, n - 1)) continue;
    if (!holds(time.first(n), runup.first(n), others, rule)) return false;
    ++held;
  }
  return held == rule.checks;
}

}  // namespace mpm
