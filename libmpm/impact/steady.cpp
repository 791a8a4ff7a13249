#include "libmpm/impact/steady.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm {

namespace {

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Variance of a sample (n - 1 in the denominator).
double variance_of(std::span<const double> values, double mean) {
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return sum / static_cast<double>(values.size() - 1);
}

/// Integrated autocorrelation time 1 + 2 sum rho_k in samples, with Sokal's window: sum up to the first lag k >= 5 tau(k).
double autocorrelation_time(std::span<const double> values, double mean) {
  double zero_lag = 0.0;
  for (const double v : values) zero_lag += (v - mean) * (v - mean);
  if (zero_lag == 0.0) return 1.0;
  double tau = 1.0;
  for (std::size_t lag = 1; lag < values.size() && static_cast<double>(lag) < 5.0 * tau; ++lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < values.size(); ++i) sum += (values[i] - mean) * (values[i - lag] - mean);
    tau += 2.0 * sum / zero_lag;
  }
  return std::max(tau, 1.0);
}

}  // namespace

SteadyCriteria impact_steady_criteria(const ImpactFlow& flow, double end) {
  if (!(flow.velocity >= 0.0) || !(flow.gravity > 0.0)) {
    throw ConfigError(fmt::format("steady span: velocity {} m/s and gravity {} m/s^2: must be at least 0 and greater than 0", flow.velocity,
                                  flow.gravity));
  }
  const double rise = flow.velocity / flow.gravity;
  SteadyCriteria criteria;
  criteria.earliest = std::max(flow.arrival, flow.constant.from) + 2.0 * rise;
  criteria.latest = flow.constant.until;
  criteria.minimum_duration = std::max(rise, (std::min(end, criteria.latest) - criteria.earliest) / 3.0);
  return criteria;
}

Steady find_steady(std::span<const double> time, std::span<const double> value, const SteadyCriteria& criteria) {
  if (value.size() != time.size())
    throw ConfigError(fmt::format("steady span: {} times and {} values: need the same number of both", time.size(), value.size()));
  std::vector<double> sum(time.size() + 1, 0.0);
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!std::isfinite(time[i]) || !std::isfinite(value[i]) || (i > 0 && !(time[i] > time[i - 1]))) {
      throw ConfigError(
          fmt::format("steady span: sample {} (time {} s, value {}): times must increase, both must be finite", i, time[i], value[i]));
    }
    sum[i + 1] = sum[i] + value[i];
  }
  const auto n = static_cast<std::size_t>(std::ranges::upper_bound(time, criteria.latest) - time.begin());
  const auto running_mean = [&](std::size_t first, std::size_t last) {
    return (sum[last] - sum[first]) / static_cast<double>(last - first);
  };

  for (std::size_t first = 0; first < n; ++first) {
    if (time[first] < criteria.earliest) continue;
    if (n - first < criteria.minimum_samples || time[n - 1] - time[first] < criteria.minimum_duration) break;
    const double end_value = running_mean(first, n), allowed = criteria.tolerance * std::abs(end_value);
    const auto settled = static_cast<std::size_t>(std::ceil(criteria.settling_fraction * static_cast<double>(n - first)));
    bool holds = end_value != 0.0;
    for (std::size_t last = first + std::max<std::size_t>(settled, 1); last <= n && holds; ++last) {
      holds = std::abs(running_mean(first, last) - end_value) <= allowed;
    }
    if (holds) return {.steady = true, .from = time[first], .to = time[n - 1], .first = first, .last = n};
  }
  return {};
}

MeanEstimate estimate_mean(std::span<const double> values) {
  std::vector<double> finite;
  std::ranges::copy_if(values, std::back_inserter(finite), [](double v) { return std::isfinite(v); });
  const std::size_t n = finite.size();
  if (n == 0) return {};
  const double mean = mean_of(finite);
  if (n < 10) return {.mean = mean, .samples = n};

  const double wanted = 5.0 * autocorrelation_time(finite, mean);
  std::size_t batches = 20;
  std::size_t length = n / batches;
  while (batches > 5 && static_cast<double>(length) < wanted) {
    batches /= 2;
    length = n / batches;
  }
  std::vector<double> batch_means;
  for (std::size_t start = n - batches * length; start < n; start += length) {
    batch_means.push_back(mean_of(std::span(finite).subspan(start, length)));
  }
  const double standard_error = std::sqrt(variance_of(batch_means, mean_of(batch_means)) / static_cast<double>(batches));
  const double count = static_cast<double>(n), variance = variance_of(finite, mean);
  const double effective = standard_error > 0.0 ? std::min(variance / (standard_error * standard_error), count) : count;
  return {
      .mean = mean, .standard_error = standard_error, .effective_samples = effective, .batches = static_cast<int>(batches), .samples = n};
}

double drift(std::span<const double> values) {
  const std::size_t half = values.size() / 2;
  return estimate_mean(values.subspan(half)).mean - estimate_mean(values.first(half)).mean;
}

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
  const double allowed = rule.standard_error * std::abs(all.mean);  // NaN, an unknown mean or error, is never below it
  const double highest_error = all.standard_error * (1.0 + std::sqrt(2.0 / (all.effective_samples - 1.0)));
  return highest_error <= allowed && std::abs(drift(values)) <= allowed;
}

/// Whether the rule holds with these samples alone.
bool rule_holds(std::span<const double> time, std::span<const double> runup, std::span<const std::span<const double>> others,
                const StopRule& rule) {
  const std::size_t n = time.size();
  const Steady span = find_steady(time, runup, impact_steady_criteria(rule.flow, time.back()));
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
    if (!rule_holds(time.first(n), runup.first(n), others, rule)) return false;
    ++held;
  }
  return held == rule.checks;
}

}  // namespace mpm
