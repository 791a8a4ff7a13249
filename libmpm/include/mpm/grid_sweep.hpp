#pragma once
/// One case at several cell sizes, particle numbers, time steps or places on the grid, and what its figures say about their own numerical
/// error: the engine behind `mpm converge`, and what the validation uses for its studies.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mpm/case.hpp"
#include "mpm/convergence.hpp"
#include "mpm/run.hpp"

namespace mpm {

/// What is varied. Cell size and CFL number go to zero, so that an order can be asked for; particles per cell and offset have no limit to
/// extrapolate to, only a scatter.
enum class SweepKind : std::uint8_t { cell_size, particles_per_cell, cfl, offset };
/// The key of [numerics] that is varied: cell_size_m, particles_per_cell, cfl, grid_offset_cells.
std::string to_string(SweepKind);

struct Sweep {
  SweepKind kind = SweepKind::cell_size;
  std::vector<double> values;  ///< m, number, number, cells
  std::string axes;            ///< of the offset, out of "xyz"; empty: all without a mirror plane
};

/// The sweep in the order in which it is run, the coarsest and cheapest first (offsets as given).
/// @throws ConfigError without values, for values twice, or an axis that is none
[[nodiscard]] Sweep in_order(Sweep sweep);

/// The case with one value of the sweep; passes every check of a case file. @throws ConfigError
[[nodiscard]] Case swept_case(const Case& c, const Sweep& sweep, double value);

/// Where one value is computed: dx_0.25, ppc_8, cfl_0.4, offset_0.5
[[nodiscard]] std::string sweep_directory(SweepKind kind, double value);

/// One run of a sweep.
struct SweepPoint {
  double value = 0.0;
  std::filesystem::path directory;
  bool reused = false;       ///< was there already, and was not run again
  std::string results_json;  ///< content of its results.json
};

struct SweepOptions {
  std::filesystem::path out;
  int threads = 0;
  bool resume = false;  ///< keep runs that are finished, go on with one that was stopped; false: run all anew
  std::function<void(const Progress&)> on_progress;
  std::function<Request()> poll;
  std::function<void(const SweepPoint&)> on_start, on_point;  ///< before and after each run; what on_point throws ends the sweep
};

struct SweepResult {
  bool finished = false;  ///< false: stopped on request
  std::vector<SweepPoint> points;
};

/// Runs the case at every value, each into a folder of its own below options.out. A run counts as finished if its results.json belongs to
/// the same case (hash) and the same duration.
/// @throws ConfigError before anything is run, if one of the cases is at fault; IoError, UnstableError
SweepResult run_sweep(const Case& c, const Sweep& sweep, const SweepOptions& options);

/// A figure with its statistical error.
struct Figure {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double value = none;           ///< NaN where there is none (a run without a steady span has no means)
  double standard_error = none;  ///< NaN where it is not known
};

/// A figure of results.json by name; components of vectors as force_mean_n[0] or force_mean_n.x.
/// @throws ConfigError for a name that is not there (suggests the nearest) or that is no number
[[nodiscard]] Figure figure_of(const std::string& results_json, const std::string& name);

/// What a sweep says about one figure. Entries of the vectors belong together; coarse first where the parameter is a size.
struct FigureStudy {
  std::string name;
  SweepKind kind = SweepKind::cell_size;
  std::vector<double> parameter;
  std::vector<Figure> figure;
  std::optional<double> exact;
  std::vector<double> error;                             ///< |value - exact|; empty without an exact value
  std::vector<double> error_order;                       ///< between neighbours: log(e_i / e_i+1) / log(h_i / h_i+1); sizes only
  std::optional<GridStudy> study;                        ///< sizes only, where at least three of them have a figure
  double lowest = Figure::none, highest = Figure::none;  ///< of the figures that exist
  /// Numerical uncertainty of the last figure, in its unit: least squares with four or more sizes, GCI with three; half the range for a
  /// parameter without a limit.
  double uncertainty = Figure::none;
  bool asymptotic = false;  ///< sizes: an order is seen, it is confirmed, and it stands out of the statistical errors
  std::string verdict;      ///< in words
};

/// Judges one figure. A difference of the two finest within twice its own statistical error, 2 sqrt(s_1^2 + s_2^2), shows no order, and the
/// verdict says so.
/// @param parameter in the order of in_order(). @param formal_order of the scheme
/// @throws ConfigError if the lengths differ
[[nodiscard]] FigureStudy study_figure(const std::string& name, SweepKind kind, std::vector<double> parameter, std::vector<Figure> figure,
                                       std::optional<double> exact = {}, double formal_order = 1.0);

/// converge.json: the points and the studies; null where there is no figure.
[[nodiscard]] std::string sweep_json(const Case& c, const Sweep& sweep, const std::vector<SweepPoint>& points,
                                     const std::vector<FigureStudy>& studies);
/// converge.csv: one row a value of the parameter; for every figure its value, standard error and, with an exact value, its error.
void write_sweep_table(const std::filesystem::path& path, const Sweep& sweep, const std::vector<FigureStudy>& studies);

}  // namespace mpm
