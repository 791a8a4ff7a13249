#pragma once
/// How well predictions meet simulated values: three of the metrics of Appendix A3.1 of the paper. python/mpmtools has all of them.

#include <span>

namespace mpm::validation {

/// Logarithms are natural; errors are ratios, not per cent.
struct Scores {
  double nrmse;  ///< sqrt(mean (y - f)^2) / mean y
  double rmsle;  ///< sqrt(mean (log y - log f)^2)
  double bias;   ///< exp(mean log(y/f)); above 1: predictions are too low
};

/// @param simulated y_i > 0. @param predicted f_i > 0, as many.
/// @throws ConfigError for no values, unequal numbers of them, or one that is not positive and finite
[[nodiscard]] Scores compute_scores(std::span<const double> simulated, std::span<const double> predicted);

}  // namespace mpm::validation
