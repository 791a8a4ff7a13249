#pragma once
/// How well predictions meet simulated values: the performance metrics of Appendix A3.1 of the paper.

#include <cstddef>
#include <span>
#include <vector>

namespace mpm {

/// All logarithms are natural; fractions and errors are ratios, not per cent.
struct Scores {
  double r2;           ///< 1 - sum (y - f)^2 / sum (y - mean y)^2; NaN where all y are equal
  double r2_log;       ///< the same of the logarithms; NaN where all y are equal
  double nrmse;        ///< sqrt(mean (y - f)^2) / mean y
  double rmsle;        ///< sqrt(mean (log y - log f)^2)
  double bias;         ///< exp(mean log(y/f)); above 1: predictions are too low
  double fraction_10;  ///< share of predictions with |y - f| / y <= 0.10
  double fraction_25;  ///< share of predictions with |y - f| / y <= 0.25
};

/// @param simulated y_i > 0. @param predicted f_i > 0, as many.
/// @throws ConfigError for no values, unequal numbers of them, or one that is not positive and finite.
[[nodiscard]] Scores compute_scores(std::span<const double> simulated, std::span<const double> predicted);

/// Scores of the rows that share a value of one input, such as a Froude number (Figs. A3 and A5).
struct GroupScores {
  double at;  ///< the value: the smallest of its group
  std::size_t rows;
  Scores scores;
};

/// Scores of each group of rows, by rising value. Values that differ by at most 1e-6 of themselves, as they do when they passed through
/// another quantity or through a table with few digits, count as one.
/// @param keys one finite value a row. @throws ConfigError as compute_scores, or for another number of keys
[[nodiscard]] std::vector<GroupScores> scores_by_group(std::span<const double> keys, std::span<const double> simulated,
                                                       std::span<const double> predicted);

}  // namespace mpm
