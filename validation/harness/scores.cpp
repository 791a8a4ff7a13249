#include "validation/harness/scores.hpp"

#include <fmt/format.h>

#include <cmath>

#include "libmpm/base/error.hpp"

namespace mpm::validation {

Scores compute_scores(std::span<const double> simulated, std::span<const double> predicted) {
  const std::size_t n = simulated.size();
  if (n == 0 || predicted.size() != n) {
    throw ConfigError(
        fmt::format("scores: {} simulated and {} predicted values: need the same number of both, at least one", n, predicted.size()));
  }
  const auto require_positive = [](const char* what, double value) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw ConfigError(fmt::format("scores: a {} value is {}: must be positive and finite", what, value));
    }
  };
  double sum = 0.0, squares = 0.0, log_ratios = 0.0, log_squares = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double y = simulated[i], f = predicted[i];
    require_positive("simulated", y);
    require_positive("predicted", f);
    const double log_ratio = std::log(y / f);
    sum += y;
    squares += (y - f) * (y - f);
    log_ratios += log_ratio;
    log_squares += log_ratio * log_ratio;
  }
  const auto count = static_cast<double>(n);
  return {
      .nrmse = std::sqrt(squares / count) / (sum / count), .rmsle = std::sqrt(log_squares / count), .bias = std::exp(log_ratios / count)};
}

}  // namespace mpm::validation
