#pragma once
/// Steady spans of a noisy series, and means over them with a standard error that accounts for autocorrelation.

#include <cstddef>
#include <limits>
#include <span>

namespace mpm {

/// What a steady span must satisfy. The paper states only "running deviation analysis"; every number here is our choice.
struct SteadyCriteria {
  double earliest = 0.0;             ///< s: no span starts sooner
  double minimum_duration = 0.0;     ///< s: no shorter span counts; the last few samples always agree with each other
  double tolerance = 0.05;           ///< allowed deviation of the running mean from its end value, relative to that value
  double settling_fraction = 0.1;    ///< the running mean is checked once it covers this fraction of the span, because few samples scatter
  std::size_t minimum_samples = 10;  ///< no span of fewer samples counts: estimate_mean has no standard error for fewer
};

/// Criteria for a flow that meets an obstacle: earliest = arrival + 2 v/g, when the first splash has fallen back; shortest span the greater
/// of v/g (the rise of a jet) and a third of the series after `earliest`, so that a series that has just become steady does
/// not count.
/// @param arrival s, when the front meets the obstacle. @param velocity v, m/s. @param end s, end of the series.
[[nodiscard]] SteadyCriteria impact_steady_criteria(double arrival, double velocity, double gravity, double end);

/// A steady span [from, to], s, of samples first .. last - 1; without one steady is false and the rest is 0.
struct Steady {
  bool steady = false;              ///< whether there is one
  double from = 0.0, to = 0.0;      ///< s
  std::size_t first = 0, last = 0;  ///< samples first .. last - 1
};

/// The longest span that ends with the series and whose running mean m(t) = mean of the samples from its start to t stays within
/// tolerance |m(end)| of m(end).
/// @param time s, increasing; evenly spaced, since each sample weighs the same. @param value as many, finite, e.g. the run-up in m.
/// @throws ConfigError if these do not hold.
[[nodiscard]] Steady find_steady(std::span<const double> time, std::span<const double> value, const SteadyCriteria& criteria);

/// Mean over a span.
struct MeanEstimate {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();  ///< unknown
  double mean = none;                                                       ///< over all finite samples
  double standard_error = none;                                             ///< of the mean
  double effective_samples =
      none;  ///< independent samples that would give this standard error: sample variance / standard_error^2, at most the number of samples
  int batches = 0;          ///< number of batches: the interval is mean +- t(batches - 1) standard_error
  std::size_t samples = 0;  ///< finite ones
};

/// Mean and standard error by non-overlapping batch means (Schmeiser 1982, Oper. Res. 30, 556): the samples are cut into 20, 10 or 5 equal
/// batches, the standard error is that of the mean of independent batch means. The largest number is used whose batches are at least five
/// autocorrelation times long (1 + 2 sum rho_k, summed up to the first lag beyond five times itself: Sokal 1997), otherwise 5. The
/// batches leave out at most batches - 1 samples at the start; the mean is over all. With 5 batches of strongly correlated samples the
/// error is still underestimated. Values that are not finite (an undefined pressure height) are left out first.
/// @return NaN for all numbers without a finite value; a standard error of NaN with fewer than 10 samples.
[[nodiscard]] MeanEstimate estimate_mean(std::span<const double> values);

}  // namespace mpm
