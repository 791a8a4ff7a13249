#pragma once
/// When the means of an impact are known well enough for the run to end: `[output] stop_when_steady`.

#include <span>

#include "libmpm/impact/impact_flow.hpp"

namespace mpm {

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
