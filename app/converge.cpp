/// `mpm converge`: one case at several grids (or particle numbers, time steps, places on the grid), and what its figures are worth.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "case_arguments.hpp"
#include "commands.hpp"
#include "mpm/error.hpp"
#include "mpm/estimate.hpp"
#include "mpm/grid_sweep.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/table.hpp"
#include "run_control.hpp"

namespace mpm::app {

namespace {

struct ConvergeArguments {
  CaseArguments input;
  std::vector<double> cell_size, particles_per_cell, cfl, offset;
  std::string offset_axes;
  std::vector<std::string> metrics;
  std::vector<double> exact;
  double formal_order = 1.0;
  std::filesystem::path out;
  int threads = 0;
  bool resume = false;
};

Sweep sweep_of(const ConvergeArguments& a) {
  if (!a.cell_size.empty()) return {SweepKind::cell_size, a.cell_size, {}};
  if (!a.particles_per_cell.empty()) return {SweepKind::particles_per_cell, a.particles_per_cell, {}};
  if (!a.cfl.empty()) return {SweepKind::cfl, a.cfl, {}};
  return {SweepKind::offset, a.offset, a.offset_axes};
}

/// What would make a grid study mean less than it seems.
std::vector<std::string> cautions(const Case& c, const Sweep& sweep) {
  std::vector<std::string> notes;
  if (sweep.kind != SweepKind::cell_size || !c.conveyor || !c.obstacle) return notes;
  const MeasurementSpec& m = c.measurement;
  if (!m.bin_height || !m.filter_length || !m.box_upstream || !m.box_inside) {
    notes.emplace_back(
        "the windows of the pressure profile follow the cell size, and their bias with them: fix bin_height_m, filter_length_m, "
        "box_upstream_m and box_inside_m in [measurement] for a study of pressures");
  }
  std::vector<std::string> odd;
  for (const double dx : sweep.values) {
    const double cells = c.obstacle->width / dx;
    if (std::abs(cells - std::round(cells)) > 1e-6) odd.push_back(fmt::format("{} ({:.3g} cells)", dx, cells));
  }
  if (!odd.empty()) notes.push_back(fmt::format("the obstacle's width is not a whole number of cells at {}", fmt::join(odd, ", ")));
  return notes;
}

std::string short_number(double x) { return std::isfinite(x) ? fmt::format("{:.5g}", x) : "none"; }

void print_values(const Sweep& sweep, const std::vector<FigureStudy>& studies) {
  static constexpr std::size_t narrowest = 12;
  const auto width = [](const std::string& name) { return std::max(name.size(), narrowest); };
  fmt::print("{:>18}", to_string(sweep.kind));
  for (const FigureStudy& s : studies) fmt::print("  {:>{}}  {:>10}", s.name, width(s.name), "std. error");
  fmt::print("\n");
  for (std::size_t i = 0; i < sweep.values.size(); ++i) {
    fmt::print("{:>18}", format_number(sweep.values[i]));
    for (const FigureStudy& s : studies) {
      fmt::print("  {:>{}}  {:>10}", short_number(s.figure[i].value), width(s.name), short_number(s.figure[i].standard_error));
    }
    fmt::print("\n");
  }
}

void print_study(const FigureStudy& s) {
  fmt::print("\n{}\n", s.name);
  const auto line = [](std::string_view what, const std::string& text) { fmt::print("  {:<28}{}\n", what, text); };
  if (s.exact) {
    std::string text;
    for (std::size_t i = 0; i < s.error.size(); ++i) text += fmt::format("{}{}", i > 0 ? ", " : "", short_number(s.error[i]));
    line(fmt::format("errors against {}", format_number(*s.exact)), text);
    text.clear();
    for (const double p : s.error_order) text += fmt::format("{}{:.2f}", text.empty() ? "" : ", ", p);
    if (!text.empty()) line("orders of the errors", text);
  }
  if (s.study) {
    const GridStudy& g = *s.study;
    for (std::size_t i = 0; i < g.triples.size(); ++i) {
      const ThreeGrids& t = g.triples[i];
      line(i + 1 == g.triples.size() ? "order, three finest" : "order, coarser",
           fmt::format("{}{} at {}, {}, {}", to_string(t.behaviour), std::isfinite(t.order) ? fmt::format(", {:.2f}", t.order) : "",
                       format_number(g.size[i]), format_number(g.size[i + 1]), format_number(g.size[i + 2])));
    }
    line("Richardson limit", short_number(g.extrapolated));
    line("GCI of the finest", fmt::format("{:.2g} % (safety factor {})", 100.0 * g.gci, g.safety_factor));
    if (std::isfinite(g.least_squares_limit)) {
      line("least squares",
           fmt::format("limit {}, {}, uncertainty {} ({:.2g} %)", short_number(g.least_squares_limit),
                       std::isfinite(g.least_squares_order) ? fmt::format("order {:.2f}", g.least_squares_order) : "prescribed orders",
                       short_number(g.least_squares_uncertainty), 100.0 * g.least_squares_uncertainty / std::abs(g.value.back())));
    }
  }
  line("verdict", s.verdict);
}

void converge(const ConvergeArguments& arguments) {
  const Case spec = read_case(arguments.input.file, arguments.input.overrides);
  const Sweep sweep = in_order(sweep_of(arguments));
  if (!arguments.exact.empty() && arguments.exact.size() != arguments.metrics.size())
    throw ConfigError(
        fmt::format("--exact: {} values for {} metrics; give one for each", arguments.exact.size(), arguments.metrics.size()));
  for (const double value : sweep.values) {
    const Estimate need = estimate(swept_case(spec, sweep, value));
    require_feasible(need, physical_memory_bytes());
    fmt::print(stderr, "{} = {}: {:.3g} particles, {:.3g} steps, {:.3g} particle-steps\n", to_string(sweep.kind), format_number(value),
               need.particles, need.steps, need.particle_steps);
  }
  for (const std::string& note : cautions(spec, sweep)) fmt::print(stderr, "note: {}\n", note);

  SweepOptions options;
  options.out = arguments.out.empty()
                    ? std::filesystem::path("out") / fmt::format("{}_{}", arguments.input.file.stem().string(), to_string(sweep.kind))
                    : arguments.out;
  options.threads = arguments.threads;
  options.resume = arguments.resume;
  const auto progress = std::make_shared<ProgressLine>();
  options.on_progress = [progress](const Progress& p) { (*progress)(p); };
  options.poll = pending_request;
  options.on_start = [&](const SweepPoint& p) {
    fmt::print(stderr, "{} = {} in {}\n", to_string(sweep.kind), format_number(p.value), p.directory.string());
  };
  std::vector<std::vector<Figure>> figures(arguments.metrics.size());
  options.on_point = [&](const SweepPoint& p) {  // a metric that does not exist ends the sweep after the first, cheapest run
    progress->finish();
    if (p.reused) fmt::print(stderr, "finished already, not run again\n");
    for (std::size_t m = 0; m < figures.size(); ++m) {
      figures[m].push_back(figure_of(p.results_json, arguments.metrics[m]));
      if (!std::isfinite(figures[m].back().value)) {
        fmt::print(stderr, "{} = {}: no {}: the run has no steady span, or does not measure it\n", to_string(sweep.kind),
                   format_number(p.value), arguments.metrics[m]);
      }
    }
  };
  listen_to_signals();
  const SweepResult result = run_sweep(spec, sweep, options);
  progress->finish();
  if (!result.finished) {
    fmt::print(stderr, "stopped; go on with --resume --out {}\n", options.out.string());
    end_by_signal();
  }

  std::vector<FigureStudy> studies;
  for (std::size_t m = 0; m < figures.size(); ++m) {
    const auto exact = arguments.exact.empty() ? std::optional<double>{} : arguments.exact[m];
    studies.push_back(study_figure(arguments.metrics[m], sweep.kind, sweep.values, figures[m], exact, arguments.formal_order));
  }
  write_file(options.out / "converge.json", sweep_json(spec, sweep, result.points, studies));
  write_sweep_table(options.out / "converge.csv", sweep, studies);
  print_values(sweep, studies);
  for (const FigureStudy& s : studies) print_study(s);
  fmt::print(stderr, "wrote {} and converge.csv\n", (options.out / "converge.json").string());
}

}  // namespace

void add_converge(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "converge",
      "Compute a case at several cell sizes (or particles per cell, CFL numbers, offsets against the grid), and judge its figures: "
      "observed orders, Richardson limit, grid convergence index, least-squares uncertainty, and whether the grids are in the asymptotic "
      "range. Each run is kept in a folder of its own (dx_0.25, ...) with converge.json and converge.csv beside them");
  const auto a = std::make_shared<ConvergeArguments>();
  add_case_arguments(*command, a->input);
  CLI::Option_group* sweeps = command->add_option_group("sweep", "What is varied: one of");
  sweeps->add_option("--cell-size", a->cell_size, "Cell sizes, m: three or more, better four, each at most 1/1.3 of the one before")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  sweeps->add_option("--particles-per-cell", a->particles_per_cell, "Particles per cell: 1, 8, 27, 64")->delimiter(',');
  sweeps->add_option("--cfl", a->cfl, "Safety factors of the time step")->delimiter(',')->check(CLI::PositiveNumber);
  CLI::Option* offset = sweeps->add_option("--offset", a->offset, "Shifts of the scene against the grid, in cells")->delimiter(',');
  sweeps->require_option(1);
  command->add_option("--offset-axes", a->offset_axes, "Axes of --offset, such as xz (default: all without a mirror plane)")->needs(offset);
  command
      ->add_option("--metric", a->metrics,
                   "Figures of results.json, one or more: runup_mean_m,force_mean_n.x (the same as force_mean_n[0])")
      ->delimiter(',')
      ->required();
  command->add_option("--exact", a->exact, "Exact values, one for each metric: errors and their orders are then shown, too")
      ->delimiter(',');
  command->add_option("--formal-order", a->formal_order, "Order that the scheme should have; 1 at walls, 2 in smooth flow without them")
      ->check(CLI::Range(0.1, 10.0))
      ->capture_default_str();
  command->add_option("--out", a->out, "Folder of the runs (default: out/<name of the case file>_<what is varied>)")->type_name("DIR");
  add_threads_argument(*command, a->threads);
  command->add_flag("--resume", a->resume, "Keep the runs that are finished, go on with the one that was stopped");
  command->callback([a] { converge(*a); });
}

}  // namespace mpm::app
