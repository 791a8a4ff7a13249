#pragma once
/// Runs and plots of impacts on the mast, for the cases with a conveyor. Every number comes from run_case and its files.

#include <filesystem>
#include <string>

#include "libmpm/driver/run.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/case.hpp"

namespace mpm::validation {

/// Relative standard deviation of the paper's equations about the paper's own simulations: run-up (RMSLE), pressure height (NRMSE).
inline constexpr double paper_runup_scatter = 0.13, paper_pressure_height_scatter = 0.066;

/// A finished run and its results.
struct ImpactRun {
  std::string id, name;  ///< for files, for readers: "fr3", "Fr 3, M' 0.4"
  Case spec;
  std::filesystem::path directory;
  RunResult result;
  Table series, profile;  ///< series.csv, profile.csv

  /// An entry of results.json; NaN where it is unknown. @param component of a vector
  [[nodiscard]] double value(const char* key, std::size_t component = 0) const { return result.results.number(key, component); }
  [[nodiscard]] bool steady() const { return value("steady") != 0.0; }

  [[nodiscard]] double flow_height() const { return spec.conveyor->flow_height; }
};

/// Runs a case with a conveyor and an obstacle in context.directory()/id, with one frame, of the end, and logs its size and time.
/// @throws UnstableError if the run left no summary of the impact
ImpactRun run_impact(const CaseContext& context, const std::string& id, const std::string& name, Case spec);

/// Run-up over time: the paper's equation (for laws that have an M'), Bernoulli's bound, and the steady mean over its span.
Plot runup_plot(const ImpactRun& run);

/// Time-mean pressure on the face over height, raw and smoothed, the hydrostatic pressure of a column of height `column`, m, and the
/// pressure height of the paper's equation.
Plot profile_plot(const ImpactRun& run, double column);

/// The last state around the mast from the side. @param window x_min, x_max, z_min, z_max, m
FlowPicture last_picture(const ImpactRun& run, FlowField field, const std::array<double, 4>& window);

/// Snow inside the obstacle at the end of a run (observe/particles_inside_obstacle.hpp).
struct SnowInside {
  double particles = 0.0, volume = 0.0;  ///< deeper than 0.1 dx behind its surface; m^3
  double depth_cells = 0.0;              ///< largest depth behind the nearest surface, in cells
};
/// Of any run with an obstacle. @param results  of results.json. @param cell_size  m
SnowInside snow_inside(const Results& results, double cell_size);
/// Checks that no particle is in the mast at the end.
void check_nothing_inside(CaseResult& result, const ImpactRun& run);

/// Size, cost, steady interval and measured quantities in one sentence.
std::string run_note(const ImpactRun& run);

}  // namespace mpm::validation
