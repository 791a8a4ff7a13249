#include "mpm/impact/scores.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mpm/error.hpp"

namespace mpm {

Scores compute_scores(std::span<const double> simulated, std::span<const double> predicted) {
  const std::size_t n = simulated.size();
  if (n == 0 || predicted.size() != n) {
    throw ConfigError(
        fmt::format("scores: {} simulated and {} predicted values: need the same number of both, at least one", n, predicted.size()));
  }
  const auto require_positive = [](const char* what, std::size_t i, double value) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw ConfigError(fmt::format("scores: {} value {} is {}: must be positive and finite", what, i, value));
    }
  };
  double mean = 0.0, mean_log = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    require_positive("simulated", i, simulated[i]);
    require_positive("predicted", i, predicted[i]);
    mean += simulated[i];
    mean_log += std::log(simulated[i]);
  }
  const double count = static_cast<double>(n);
  mean /= count;
  mean_log /= count;

  double residual = 0.0, residual_log = 0.0, total = 0.0, total_log = 0.0, log_ratio = 0.0;
  double within_10 = 0.0, within_25 = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double y = simulated[i], f = predicted[i];
    const double difference = y - f, difference_log = std::log(y / f);
    residual += difference * difference;
    residual_log += difference_log * difference_log;
    total += (y - mean) * (y - mean);
    total_log += (std::log(y) - mean_log) * (std::log(y) - mean_log);
    log_ratio += difference_log;
    within_10 += std::abs(difference) / y <= 0.10 ? 1.0 : 0.0;
    within_25 += std::abs(difference) / y <= 0.25 ? 1.0 : 0.0;
  }
  // Rounding of the mean can leave a total that is not exactly zero: ask the values.
  const bool all_equal = std::ranges::all_of(simulated, [&](double y) { return y == simulated[0]; });
  const auto determination = [&](double res, double tot) { return all_equal ? std::numeric_limits<double>::quiet_NaN() : 1.0 - res / tot; };
  return {.r2 = determination(residual, total),
          .r2_log = determination(residual_log, total_log),
          .nrmse = std::sqrt(residual / count) / mean,
          .rmsle = std::sqrt(residual_log / count),
          .bias = std::exp(log_ratio / count),
          .fraction_10 = within_10 / count,
          .fraction_25 = within_25 / count};
}

std::vector<GroupScores> scores_by_group(std::span<const double> keys, std::span<const double> simulated,
                                         std::span<const double> predicted) {
  constexpr double same = 1e-6;
  if (keys.size() != simulated.size() || predicted.size() != simulated.size()) {
    throw ConfigError(fmt::format("scores by group: {} keys, {} simulated and {} predicted values: need the same number of each",
                                  keys.size(), simulated.size(), predicted.size()));
  }
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return keys[i]; });
  std::vector<GroupScores> groups;
  for (std::size_t first = 0; first < order.size();) {
    const double at = keys[order[first]];
    std::vector<double> y, f;
    for (; first < order.size() && keys[order[first]] <= at + same * std::abs(at); ++first) {
      y.push_back(simulated[order[first]]);
      f.push_back(predicted[order[first]]);
    }
    groups.push_back({at, y.size(), compute_scores(y, f)});
  }
  return groups;
}

}  // namespace mpm
