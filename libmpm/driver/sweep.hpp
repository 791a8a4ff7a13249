#pragma once
/// A sweep: one case at several cell sizes, particle numbers, time steps or places on the grid, each in a folder of its own. Used by
/// `mpm converge`; metric_convergence.hpp evaluates the results.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/run.hpp"

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

/// The case with one value of the sweep; passes every check of a case file. @throws ConfigError
[[nodiscard]] Case swept_case(const Case& c, const Sweep& sweep, double value);

/// Folder of one value: dx_0.25, ppc_8, cfl_0.4, offset_0.5
[[nodiscard]] std::string sweep_directory(SweepKind kind, double value);

/// One run of a sweep.
struct SweepPoint {
  double value = 0.0;               ///< of the parameter
  std::filesystem::path directory;  ///< its folder
  bool reused = false;              ///< the run was complete before, and was not repeated
  Results results;                  ///< of its results.json
};

/// Options of a sweep.
struct SweepOptions {
  std::filesystem::path out;  ///< each run gets a folder in it
  RunOptions run;             ///< of each run, but for its folder; with `resume`, finished runs are kept
  bool overwrite = false;     ///< replace results and checkpoints in the folders; false: refuse
  /// Computes one case; empty: run_case.
  std::function<RunResult(const Case&, const RunOptions&)> compute;
  std::function<void(const SweepPoint&)> on_start, on_point;  ///< before and after each run; an exception of on_point ends the sweep
};

/// Outcome of a sweep.
struct SweepResult {
  bool finished = false;           ///< false: stopped on request
  std::vector<SweepPoint> points;  ///< those that are complete, in the order of the values
};

/// Runs the case at every value, each into a folder of its own below options.out. A run counts as finished if its results.json belongs to
/// the same case (hash) and the same duration.
/// @throws ConfigError before anything is run or removed, if one of the cases is invalid or a run would replace results: without
/// `run.resume`
///         any results or checkpoint, with it those of another case or duration; IoError, UnstableError
SweepResult run_sweep(const Case& c, const Sweep& sweep, const SweepOptions& options);

}  // namespace mpm
