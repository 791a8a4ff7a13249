#pragma once
/// What one choice at a time does to run-up, pressure height and force (supplement S1 of the paper): each run of a table against the
/// base's run of the same flow, snow and width of mast.

#include <filesystem>
#include <string>
#include <vector>

#include "mpm/impact/steady.hpp"

namespace mpm {

struct Sensitivity {
  std::string choice;  ///< column that differs from the base, or several joined by ", "; empty for the base itself
  std::string value;   ///< of that column
  double froude, critical_state_slope, cohesion_beta, hardening_xi, effective_friction;
  MeanRatio runup, pressure_height, force;                  ///< over the base's; NaN where one of the two has none
  double runup_to_published, pressure_height_to_published;  ///< over Eqs. 7 to 10 with the published coefficients
};

/// Geometric mean, lowest and highest of ratios; NaN of none.
struct RatioSpread {
  double mean, low, high;
};

/// One value of a choice over all its points, only those with a steady run-up; the base is the one whose choice is empty.
struct SensitivitySummary {
  std::string choice, value;
  std::size_t points;
  RatioSpread runup, pressure_height, force;  ///< over the base's
  double runup_rmsle, base_runup_rmsle;       ///< from the published equation: of these runs, and of the base's at the same points
};

struct SensitivityStudy {
  std::vector<Sensitivity> runs;
  std::vector<SensitivitySummary> summaries;
  std::vector<std::string> notes;  ///< points without a base, runs that were left out
};

/// Reads a campaign's results.csv. Choices are the columns obstacle_friction, obstacle_friction_ratio, cell_size_m and those named
/// after a key (`numerics.slope_deg`), durations and rates of output excepted. The base has in each of them the value that most rows have;
/// the mast's friction follows from its ratio where the ratio is the base's. What else was done to friction is told by the one of its two
/// columns whose value more points share.
/// @throws IoError for a file that cannot be read or lacks a column
[[nodiscard]] SensitivityStudy sensitivities(const std::filesystem::path& results);

}  // namespace mpm
