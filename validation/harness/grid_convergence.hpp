#pragma once
/// Convergence in grid or time step, and scatter, for cases: pass the sizes and a function that computes some quantities at one size. The
/// result is evaluated and written to the report.
///
///   const auto judged = record_convergence(result, "dam", SweepKind::cell_size, {0.2, 0.1, 0.05},
///                                          {{.quantity = "front at t = 1 s", .unit = "m", .exact = 4.43}},
///                                          [&](double dx) { return std::vector<Metric>{{front(dx)}}; });

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/driver/metric_convergence.hpp"
#include "validation/harness/case.hpp"

namespace mpm::validation {

/// A quantity whose convergence is evaluated.
struct FollowedQuantity {
  std::string quantity, unit;
  double formal_order = 1.0;
  std::optional<double> exact = {};
};

/// Computes the quantities at every value of the parameter, in the order of in_order() (coarse first), and records for each of them
/// - a NamedConvergence, where at least three sizes have a value: the report draws it;
/// - with an exact value, the log-log plot `id`-`number` of the errors over the size with a line of the formal order;
/// - a note: the last value with its numerical and statistical uncertainty, and the verdict, which also names parameters without a value.
/// @param compute the values at one parameter, in the order of `quantities`; NaN if there is none
std::vector<MetricConvergence> record_convergence(CaseResult& result, const std::string& id, SweepKind kind, std::vector<double> values,
                                                  const std::vector<FollowedQuantity>& quantities,
                                                  const std::function<std::vector<Metric>(double)>& compute);

/// The last value with its uncertainties: "3.86 m, numerical uncertainty 0.25 m, statistical (two standard errors) 0.05 m".
std::string with_uncertainty(const MetricConvergence& judged, const std::string& unit);

}  // namespace mpm::validation
