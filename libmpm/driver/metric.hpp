#pragma once
/// Metrics: numbers of results.json by name, as `mpm converge --metric` takes them. Components of vectors are force_mean_n.x; the index
/// of results.json, force_mean_n[0], is understood.

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"

namespace mpm {

/// A metric with its statistical error.
struct Metric {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();  ///< unknown
  double value = none;           ///< NaN if the run has none (a run without a steady interval has no means)
  double standard_error = none;  ///< NaN if unknown
};

/// The name of component i of a vector, force_mean_n.x, as all tables and commands have it; of an array of another size, name[i].
[[nodiscard]] std::string component_name(const std::string& vector, std::size_t i, std::size_t size);

/// The entry that holds the standard error of another one: X_standard_error_UNIT of X_mean_UNIT; empty for other names.
[[nodiscard]] std::string standard_error_name(std::string name);

/// The metric of a results.json.
/// @throws ConfigError for an unknown name (suggests the nearest), or that is not a number; IoError if the text is not JSON
[[nodiscard]] Metric metric_of(const std::string& results_json, const std::string& name);

/// Names of all metrics that a run of this case reports, vectors by component.
[[nodiscard]] std::vector<std::string> known_metrics(const Case& c);

/// Checks the names of metrics before anything is computed.
/// @throws ConfigError for the first name that no run of this case reports; suggests the nearest
void require_known_metrics(const Case& c, const std::vector<std::string>& names);

}  // namespace mpm
