#pragma once
/// Steady spans of a noisy series, means over them with a standard error that accounts for autocorrelation, and when the means of an
/// impact are known well enough for the run to end: `[output] stop_when_steady`.

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

namespace mpm {

/// While snow of constant speed, height and density is at the obstacle, s: before, an inflow varies; after, a strip thins from its rear.
struct ConstantFlow {
  double from = 0.0, until = std::numeric_limits<double>::infinity();  ///< s
};

/// Input of steady criteria, force peaks and predictions.
struct ImpactFlow {
  double velocity = 0.0;                     ///< v, m/s
  double gravity = 9.81;                     ///< g, m/s^2
  double arrival = 0.0;                      ///< s; the conveyor's front is at the face at t = 0
  ConstantFlow constant;                     ///< steady intervals lie in it
  std::optional<double> effective_friction;  ///< M'; empty for laws without M': no prediction
};

/// What a steady span must satisfy. The paper states only "running deviation analysis"; every number here is our choice.
struct SteadyCriteria {
  double earliest = 0.0;                                    ///< s: no span starts sooner
  double latest = std::numeric_limits<double>::infinity();  ///< s: no span ends later
  double minimum_duration = 0.0;     ///< s: no shorter span counts; the last few samples always agree with each other
  double tolerance = 0.05;           ///< allowed deviation of the running mean from its end value, relative to that value
  double settling_fraction = 0.1;    ///< the running mean is checked once it covers this fraction of the span, because few samples scatter
  std::size_t minimum_samples = 10;  ///< no span of fewer samples counts: estimate_mean has no standard error for fewer
};

/// Criteria for a flow that meets an obstacle: while its snow is constant, from 2 v/g after the first of it, when a splash has fallen back;
/// shortest span the greater of v/g (the rise of a jet) and a third of what is left of the series, so that a series that has just become
/// steady does not count.
/// @param end s, end of the series.
[[nodiscard]] SteadyCriteria impact_steady_criteria(const ImpactFlow& flow, double end);

/// A steady span [from, to], s, of samples first .. last - 1; without one steady is false and the rest is 0.
struct Steady {
  bool steady = false;              ///< whether there is one
  double from = 0.0, to = 0.0;      ///< s
  std::size_t first = 0, last = 0;  ///< samples first .. last - 1
};

/// The longest span that ends with the series, or at the latest sample that may count, and whose running mean m(t) = mean of the samples
/// from its start to t stays within tolerance |m(end)| of m(end). None where m(end) is zero: nothing is there.
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

/// How far a quantity is from steady: mean over the second half of its values less that over the first; NaN without values.
[[nodiscard]] double drift(std::span<const double> values);

/// A slow pile needs a distance, not a time, to become steady: the paper's shortest run (Table 2, Fr 0.1: 27.9 m less the 3 m that L adds)
/// is this many flow heights.
inline constexpr double least_passage_heights = 14.0;

/// What the rule waits for: three times that. With once, fluids at Fr 1, whose run-up falls before it rises, ended up to 20 % too low
/// (reference_data/stop_when_steady).
inline constexpr double settled_passage_heights = 3.0 * least_passage_heights;

/// The rule looks at the series at certain times only, the checks, and ends the run when it holds at `checks` of them in succession. At a
/// check, with everything up to it, it holds if
///   - the run-up has a steady interval (impact_steady_criteria, find_steady);
///   - over that interval the means of all quantities have a relative standard error of at most `standard_error`, where two standard
///     deviations of the error's own estimate are added: it is SE (1 + sqrt(2/(n - 1))) with n independent samples (estimate_mean);
///   - and the means of its two halves differ by at most `standard_error` of the mean: a pile that still grows has no mean yet.
/// The numbers are choices; reference_data/stop_when_steady judges them against runs of full duration.
struct StopRule {
  ImpactFlow flow;              ///< sets when the steady interval may start
  double standard_error = 0.0;  ///< largest, over the mean; 0: no run ends by the rule
  double first_check = 0.0;     ///< s
  double check_interval = 1.0;  ///< s, between checks
  int checks = 3;               ///< in succession at which the rule must hold
};

/// The rule for a flow that meets an obstacle. Checks begin when the first splash has fallen back and lasted once more (arrival + 3 v/g),
/// and not before the flow has travelled `passage`. Between two checks a jet rises (v/g) and the flow passes its own height (H/v).
/// @param standard_error largest relative standard error, in [0, 1). @param flow_height H, m. @param passage m
[[nodiscard]] StopRule impact_stop_rule(double standard_error, const ImpactFlow& flow, double flow_height, double passage);

/// Whether a run may end after the last of these samples. Depends on nothing but these numbers: the same on any number of threads and ranks
/// and after a resumption.
/// @param time s, increasing. @param runup m, as many, finite. @param others further quantities whose means must be known, as many; NaN
/// where they are undefined
[[nodiscard]] bool may_end(std::span<const double> time, std::span<const double> runup, std::span<const std::span<const double>> others,
                           const StopRule& rule);

}  // namespace mpm
