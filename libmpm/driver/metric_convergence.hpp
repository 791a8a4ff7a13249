#pragma once
/// Metrics: numbers of results.json by name, as `mpm converge --metric` takes them; and the convergence of one metric in a sweep: order,
/// limit and uncertainty if the parameter goes to zero, otherwise the scatter. The validation uses it for its own quantities.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/convergence.hpp"
#include "libmpm/observe/results.hpp"

namespace mpm {

/// The parameter that is varied.
enum class SweepKind : std::uint8_t { cell_size, particles_per_cell, cfl, offset };
/// The key of [numerics] that is varied: cell_size_m, particles_per_cell, cfl, grid_offset_cells.
std::string to_string(SweepKind);
/// Cell size and CFL number go to zero, so that an order can be determined; particles per cell and offset have no limit to extrapolate to;
/// only the scatter is evaluated.
[[nodiscard]] bool goes_to_zero(SweepKind kind);

/// The values of one parameter.
struct Sweep {
  SweepKind kind = SweepKind::cell_size;  ///< which parameter
  std::vector<double> values;             ///< m, number, number, cells
  std::string axes;                       ///< of the offset, out of "xyz"; empty: all without a mirror plane
};

/// The sweep in the order in which it is run, the coarsest and cheapest first (offsets as given).
/// @throws ConfigError without values, for equal values, or an unknown axis
[[nodiscard]] Sweep in_order(Sweep sweep);

/// A metric with its statistical error.
struct Metric {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();  ///< unknown
  double value = none;           ///< NaN if the run has none (a run without a steady interval has no means)
  double standard_error = none;  ///< NaN if unknown
};

/// The metric of a results.json.
/// @throws ConfigError for an unknown name (suggests the nearest), or that is not a number
[[nodiscard]] Metric metric_of(const Results& results, const std::string& name);

/// Names of all metrics that a run of this case reports, vectors by component.
[[nodiscard]] std::vector<std::string> known_metrics(const Case& c);

/// Checks the names of metrics before anything is computed.
/// @throws ConfigError for the first name that no run of this case reports; suggests the nearest
void require_known_metrics(const Case& c, const std::vector<std::string>& names);

/// One metric over the values of a parameter. The vectors have one entry for each value; coarse first if the parameter is a size.
struct MetricConvergence {
  std::string name;                                      ///< name in results.json, vectors by component
  SweepKind kind = SweepKind::cell_size;                 ///< what was varied
  std::vector<double> parameter;                         ///< its values, in the unit of Sweep::values
  std::vector<Metric> metric;                            ///< one for each value
  std::optional<double> exact;                           ///< exact value, if the caller knows it
  std::vector<double> error;                             ///< |value - exact|; empty without an exact value
  std::vector<double> error_order;                       ///< between neighbours: log(e_i / e_i+1) / log(h_i / h_i+1); sizes only
  std::optional<Convergence> convergence;                ///< sizes only, if at least three of them have a value
  double lowest = Metric::none, highest = Metric::none;  ///< over the existing values
  /// Numerical uncertainty of the last value, in its unit: that of judge_convergence for a size; half the range for a parameter without a
  /// limit.
  double uncertainty = Metric::none;
  double total_uncertainty = Metric::none;  ///< the same and two standard errors of that value, root of the sum of squares: to quote
  bool asymptotic = false;  ///< sizes: an order is observed and confirmed, and the differences exceed the statistical errors
  std::string verdict;      ///< in words
};

/// Sizes are judged only if each is at least this many times the next finer one. Closer ones show noise instead of an order: 1.3 is
/// recommended (Celik et al. 2008); whole numbers of cells across an obstacle (w/4, w/5: 1.25; w/9, w/11: 1.22) come close.
inline constexpr double least_size_ratio = 1.2;

/// Judges one metric. A difference of the two finest within twice its own statistical error, 2 sqrt(s_1^2 + s_2^2), shows no order; the
/// verdict states it. Of sizes that are closer than least_size_ratio only the finest is judged.
/// @param parameter in the order of in_order(). @param formal_order of the scheme
/// @throws ConfigError if the lengths differ
[[nodiscard]] MetricConvergence judge_metric(const std::string& name, SweepKind kind, std::vector<double> parameter,
                                             std::vector<Metric> metric, std::optional<double> exact = {}, double formal_order = 1.0);

/// One line: the last value, its total uncertainty and where that comes from, or why none is known.
[[nodiscard]] std::string quote(const MetricConvergence& m);

}  // namespace mpm
