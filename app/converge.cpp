/// `mpm converge`: one case at several grids (or particle numbers, time steps, places on the grid), and the uncertainty of its metrics.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "case_arguments.hpp"
#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/driver/metric_convergence.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sweep.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "ranks.hpp"
#include "run_control.hpp"
#include "validators.hpp"

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
  int threads = 0, ranks = 1;
  bool resume = false, force = false, details = false;
};

Sweep sweep_of(const ConvergeArguments& a) {
  if (!a.cell_size.empty()) return {SweepKind::cell_size, a.cell_size, {}};
  if (!a.particles_per_cell.empty()) return {SweepKind::particles_per_cell, a.particles_per_cell, {}};
  if (!a.cfl.empty()) return {SweepKind::cfl, a.cfl, {}};
  return {SweepKind::offset, a.offset, a.offset_axes};
}

std::string short_number(double x) { return std::isfinite(x) ? fmt::format("{:.5g}", x + 0.0) : "none"; }  // + 0.0: no "-0"

void print_values(const Sweep& sweep, const std::vector<MetricConvergence>& metrics) {
  static constexpr std::size_t narrowest = 12;
  const auto width = [](const std::string& name) { return std::max(name.size(), narrowest); };
  fmt::print("{:>18}", to_string(sweep.kind));
  for (const MetricConvergence& s : metrics) fmt::print("  {:>{}}  {:>10}", s.name, width(s.name), "std. error");
  fmt::print("\n");
  for (std::size_t i = 0; i < sweep.values.size(); ++i) {
    fmt::print("{:>18}", format_number(sweep.values[i]));
    for (const MetricConvergence& s : metrics) {
      fmt::print("  {:>{}}  {:>10}", short_number(s.metric[i].value), width(s.name), short_number(s.metric[i].standard_error));
    }
    fmt::print("\n");
  }
}

void print_convergence(const MetricConvergence& s, bool details) {
  fmt::print("\n{}\n", s.name);
  const auto line = [](std::string_view what, const std::string& text) { fmt::print("  {:<28}{}\n", what, text); };
  if (s.exact) {
    std::vector<std::string> errors;
    errors.reserve(s.error.size());
    for (const double error : s.error) errors.push_back(short_number(error));
    line(fmt::format("errors against {}", format_number(*s.exact)), fmt::format("{}", fmt::join(errors, ", ")));
    if (!s.error_order.empty()) line("orders of the errors", fmt::format("{:.2f}", fmt::join(s.error_order, ", ")));
  }
  if (s.convergence && details) {
    const Convergence& g = *s.convergence;
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
    line("numerical uncertainty",
         fmt::format("{} ({:.2g} %), {}", short_number(g.uncertainty), 100.0 * g.uncertainty / std::abs(g.value.back()), g.basis));
  }
  line("verdict", s.verdict);
}

/// Prints the value and the uncertainty to quote for each metric, and what to know before they are used.
void print_quotes(const Case& spec, const Sweep& sweep, const std::vector<MetricConvergence>& metrics) {
  fmt::print("\n");
  for (const MetricConvergence& m : metrics) fmt::print("{}\n", quote(m));
  for (const std::string& note : study_notes(spec, sweep)) fmt::print("note: {}\n", note);
}

/// Refuses cases that cannot be computed, and prints the estimated cost of each value of the sweep.
void check(const ConvergeArguments& arguments, const Case& spec, const Sweep& sweep) {
  if (!arguments.exact.empty() && arguments.exact.size() != arguments.metrics.size())
    throw ConfigError(fmt::format("--exact: {} for {}; give one for each", counted(arguments.exact.size(), "value"),
                                  counted(arguments.metrics.size(), "metric")));
  require_known_metrics(spec, arguments.metrics);
  for (const double value : sweep.values) {
    const Estimate need = estimate(swept_case(spec, sweep, value));
    require_feasible(need, physical_memory_bytes());
    fmt::print(stderr, "{} = {}: {:.3g} particles, {:.3g} steps, {:.3g} particle-steps\n", to_string(sweep.kind), format_number(value),
               need.particles, need.steps, need.particle_steps);
  }
  for (const std::string& note : study_notes(spec, sweep)) fmt::print(stderr, "note: {}\n", note);
}

/// Runs the sweep, with progress; does not return if a signal stopped it.
std::vector<SweepPoint> compute(const ConvergeArguments& arguments, const Case& spec, const Sweep& sweep,
                                const std::filesystem::path& out) {
  ProgressLine progress;
  SweepOptions options;
  options.out = out;
  options.run.threads = arguments.threads;
  options.run.resume = arguments.resume;
  options.run.on_progress = [&](const Progress& p) { progress(p); };
  options.run.poll = pending_request;
  options.overwrite = arguments.force;
  options.compute = [](const Case& c, const RunOptions& run) { return session().run(c, run); };
  options.on_start = [&](const SweepPoint& p) {
    fmt::print(stderr, "{} = {} in {}\n", to_string(sweep.kind), format_number(p.value), p.directory.string());
  };
  options.on_point = [&](const SweepPoint& p) {
    progress.finish();
    if (p.reused) fmt::print(stderr, "finished already, not run again\n");
    for (const std::string& metric : arguments.metrics) {
      if (!std::isfinite(metric_of(p.results, metric).value)) {
        fmt::print(stderr, "{} = {}: no {}: the run has no steady interval, or does not measure it\n", to_string(sweep.kind),
                   format_number(p.value), metric);
      }
    }
  };
  listen_to_signals();
  const SweepResult result = run_sweep(spec, sweep, options);
  progress.finish();
  if (!result.finished) {
    fmt::print(stderr, "to continue: the same command with --resume --out {}\n", out.string());
    session().close(0);
    end_by_signal();
  }
  return result.points;
}

void converge(const ConvergeArguments& arguments) {
  if (arguments.ranks > 1 && session().size() == 1) become_ranks(arguments.ranks);
  const Case spec = read_case(arguments.input.file, arguments.input.overrides);
  const Sweep sweep = in_order(sweep_of(arguments));
  check(arguments, spec, sweep);
  const std::string default_name = fmt::format("{}_{}", arguments.input.file.stem().string(), to_string(sweep.kind));
  const std::filesystem::path out = arguments.out.empty() ? std::filesystem::path("out") / default_name : arguments.out;
  if (arguments.resume) require_folder(out);
  if (!arguments.resume && !arguments.force && std::filesystem::exists(out / "converge.csv"))
    throw ConfigError(fmt::format(
        "{} holds a study; choose another folder with --out, keep its runs with --resume, or overwrite with --force", out.string()));
  const std::vector<SweepPoint> points = compute(arguments, spec, sweep, out);

  std::vector<MetricConvergence> metrics;
  for (std::size_t i = 0; i < arguments.metrics.size(); ++i) {
    std::vector<Metric> values;
    values.reserve(points.size());
    for (const SweepPoint& p : points) values.push_back(metric_of(p.results, arguments.metrics[i]));
    const auto exact = arguments.exact.empty() ? std::optional<double>{} : arguments.exact[i];
    metrics.push_back(judge_metric(arguments.metrics[i], sweep.kind, sweep.values, std::move(values), exact, arguments.formal_order));
  }
  write_file(out / "converge.json", converge_json(spec, sweep, points, metrics));
  write_converge_table(out / "converge.csv", sweep, metrics);
  print_values(sweep, metrics);
  for (const MetricConvergence& m : metrics) {
    if (arguments.details || m.exact) print_convergence(m, arguments.details);
  }
  print_quotes(spec, sweep, metrics);
  fmt::print(stderr, "wrote {} and converge.csv\n", (out / "converge.json").string());
}

}  // namespace

void add_converge(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "converge",
      "Compute a case at several cell sizes (or particles per cell, CFL numbers, offsets against the grid), and estimate the numerical "
      "uncertainty of its metrics: one line for each with the value and the uncertainty to quote; --details: how it was found. Each run "
      "has a folder of its own (dx_0.25, ...); converge.json and converge.csv are beside them");
  const auto a = std::make_shared<ConvergeArguments>();
  add_case_arguments(*command, a->input);
  CLI::Option_group* sweeps = command->add_option_group("sweep", "What is varied: one of");
  sweeps->add_option("--cell-size", a->cell_size, "Cell sizes, m: three or more, better four, each at most 1/1.3 of the one before")
      ->delimiter(',')
      ->check(above_zero());
  sweeps->add_option("--particles-per-cell", a->particles_per_cell, "Particles per cell: 1, 8, 27, 64")->delimiter(',');
  sweeps->add_option("--cfl", a->cfl, "Safety factors of the time step")->delimiter(',')->check(above_zero());
  CLI::Option* offset = sweeps->add_option("--offset", a->offset, "Shifts of the scene against the grid, in cells")->delimiter(',');
  sweeps->require_option(1);
  command->add_option("--offset-axes", a->offset_axes, "Axes of --offset, such as xz (default: all without a mirror plane)")->needs(offset);
  command
      ->add_option("--metric", a->metrics,
                   "Numbers of results.json, one or more: runup_p99_mean_m,force_mean_n.x (the same as force_mean_n[0])")
      ->delimiter(',')
      ->required();
  command->add_option("--exact", a->exact, "Exact values, one for each metric: also print the errors and their orders")->delimiter(',');
  command->add_flag("--details", a->details, "Also print how the uncertainty was found: orders, Richardson limit, GCI, least squares");
  command->add_option("--formal-order", a->formal_order, "Order that the scheme should have: 1 at walls, 2 in smooth flow without walls")
      ->check(in_range(0.1, 10.0))
      ->capture_default_str();
  command->add_option("--out", a->out, "Folder of the runs (default: out/<name of the case file>_<what is varied>)")->type_name("DIR");
  add_threads_argument(*command, a->threads);
  add_ranks_argument(*command, a->ranks, "Processes of each run, started by mpirun (default: 1, or those of the mpirun that started this)");
  CLI::Option* resume = command->add_flag("--resume", a->resume, "Keep the finished runs, continue the one that was interrupted");
  command->add_flag("--force", a->force, "Overwrite the results of earlier runs in the folder")->excludes(resume);
  command->callback([a] { converge(*a); });
}

}  // namespace mpm::app
