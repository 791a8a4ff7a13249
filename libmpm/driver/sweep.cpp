#include "libmpm/driver/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

/// Checks a folder for a sweep with `resume`: it may hold a finished or interrupted run of this case, but no results of another case or
/// duration.
void require_same_run(const std::filesystem::path& directory, const Case& c) {
  const ResultsFile file(directory);
  if (!file.exists() || file.is_finished(c) || !file.damage().empty()) return;  // what is damaged is computed again, if it is of this case
  throw ConfigError(
      fmt::format("{} holds the results of another case or of another duration; choose another folder with --out, or overwrite it with "
                  "--force instead of --resume",
                  directory.string()));
}

}  // namespace

std::string to_string(SweepKind kind) {
  switch (kind) {
    case SweepKind::cell_size: return "cell_size_m";
    case SweepKind::particles_per_cell: return "particles_per_cell";
    case SweepKind::cfl: return "cfl";
    case SweepKind::offset: return "grid_offset_cells";
  }
  return {};
}

bool goes_to_zero(SweepKind kind) { return kind == SweepKind::cell_size || kind == SweepKind::cfl; }

Sweep in_order(Sweep sweep) {
  if (sweep.values.empty()) throw ConfigError(fmt::format("sweep of {}: no values", to_string(sweep.kind)));
  if (goes_to_zero(sweep.kind)) std::ranges::sort(sweep.values, std::greater{});
  if (sweep.kind == SweepKind::particles_per_cell) std::ranges::sort(sweep.values);
  for (std::size_t i = 0; i < sweep.values.size(); ++i) {
    if (std::count(sweep.values.begin(), sweep.values.end(), sweep.values[i]) > 1)
      throw ConfigError(fmt::format("sweep of {}: {} is given twice; give each value once", to_string(sweep.kind), sweep.values[i]));
  }
  for (const char axis : sweep.axes) {
    if (std::string_view("xyz").find(axis) == std::string_view::npos || std::ranges::count(sweep.axes, axis) > 1)
      throw ConfigError(fmt::format("sweep of {}: axes '{}'; give some of x, y and z, each once", to_string(sweep.kind), sweep.axes));
  }
  return sweep;
}

Case swept_case(const Case& c, const Sweep& sweep, double value) {
  std::string text = format_number(value);
  if (sweep.kind == SweepKind::offset) {
    std::string axes = sweep.axes;
    if (axes.empty()) {
      if (!c.domain.mirror_x) axes += 'x';
      if (!c.domain.mirror_y && !(c.conveyor && c.conveyor->mirror_y)) axes += 'y';
      axes += 'z';
    }
    const auto along = [&](char axis) { return axes.find(axis) == std::string::npos ? std::string("0") : text; };
    text = fmt::format("[{}, {}, {}]", along('x'), along('y'), along('z'));
  }
  return parse_case(write_case(c), "case", {fmt::format("numerics.{}={}", to_string(sweep.kind), text)});
}

std::string sweep_directory(SweepKind kind, double value) {
  const char* prefix = kind == SweepKind::cell_size            ? "dx"
                       : kind == SweepKind::particles_per_cell ? "ppc"
                       : kind == SweepKind::cfl                ? "cfl"
                                                               : "offset";
  return fmt::format("{}_{}", prefix, format_number(value));
}

SweepResult run_sweep(const Case& c, const Sweep& sweep, const SweepOptions& options) {
  const Sweep ordered = in_order(sweep);
  std::vector<Case> cases;
  for (const double value : ordered.values) cases.push_back(swept_case(c, ordered, value));
  const auto directory = [&](std::size_t i) { return options.out / sweep_directory(ordered.kind, ordered.values[i]); };
  for (std::size_t i = 0; i < cases.size() && !options.overwrite; ++i) {
    if (options.run.resume)
      require_same_run(directory(i), cases[i]);
    else
      require_no_results(directory(i));
  }
  SweepResult result;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SweepPoint point{ordered.values[i], directory(i), false, {}};
    if (options.on_start) options.on_start(point);
    if (const auto finished = options.run.resume ? finished_results(point.directory, cases[i]) : std::nullopt) {
      point.reused = true;
      point.results = *finished;
    } else {
      RunOptions run = options.run;
      run.out = point.directory;
      const RunResult done = options.compute ? options.compute(cases[i], run) : run_case(cases[i], run);
      if (!done.finished) return result;
      point.results = done.results;
    }
    result.points.push_back(point);
    if (options.on_point) options.on_point(result.points.back());
  }
  result.finished = true;
  return result;
}

}  // namespace mpm
