/// `mpm converge`: one case at several grids (or particle numbers, time steps, places on the grid), and the uncertainty of its metrics.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "arguments.hpp"
#include "campaign_control.hpp"
#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/campaign/grid_study.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm::app {

namespace {

struct ConvergeArguments {
  CaseArguments input;
  CampaignArguments campaign;
  std::vector<double> cell_size, particles_per_cell, cfl, offset;
  std::string offset_axes;
  std::vector<std::string> metrics;
  std::vector<double> exact;
  double formal_order = 1.0;
  int threads = 0;
  bool details = false;
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

/// The study, coarse first; prints the estimated cost of each run and the notes. @throws ConfigError if a run cannot be computed
Campaign planned(const ConvergeArguments& a, const Case& spec, const Sweep& sweep) {
  if (!a.exact.empty() && a.exact.size() != a.metrics.size())
    throw ConfigError(
        fmt::format("--exact: {} for {}; give one for each", counted(a.exact.size(), "value"), counted(a.metrics.size(), "metric")));
  require_known_metrics(spec, a.metrics);
  const int threads =
      a.threads > 0 ? a.threads : std::max(1, omp_get_max_threads() / std::max(1, a.campaign.ranks) / std::max(1, a.campaign.jobs));
  Campaign study = make_grid_study(spec, sweep, threads, a.campaign.ranks);
  for (const CampaignRun& run : study.runs) {
    require_feasible(run.cost, physical_memory_bytes());
    fmt::print(stderr, "{}: {:.3g} particles, {:.3g} steps, {:.3g} particle-steps\n", run.name, run.cost.particles, run.cost.steps,
               run.cost.particle_steps);
  }
  for (const std::string& note : study_notes(spec, sweep)) fmt::print(stderr, "note: {}\n", note);
  return study;
}

/// The metrics over the finished runs; reports those without a value.
std::vector<MetricConvergence> judged(const ConvergeArguments& a, const Sweep& sweep, const std::vector<RunStatus>& status) {
  std::vector<MetricConvergence> metrics;
  for (std::size_t m = 0; m < a.metrics.size(); ++m) {
    std::vector<Metric> values;
    for (std::size_t i = 0; i < status.size(); ++i) {
      values.push_back(metric_of(status[i].results, a.metrics[m]));
      if (!std::isfinite(values.back().value)) {
        fmt::print(stderr, "{} = {}: no {}: the run has no steady interval, or does not measure it\n", to_string(sweep.kind),
                   format_number(sweep.values[i]), a.metrics[m]);
      }
    }
    const auto exact = a.exact.empty() ? std::optional<double>{} : a.exact[m];
    metrics.push_back(judge_metric(a.metrics[m], sweep.kind, sweep.values, std::move(values), exact, a.formal_order));
  }
  return metrics;
}

void converge(ConvergeArguments a) {
  for (std::string& metric : a.metrics) std::erase(metric, ' ');  // after a comma
  const Case spec = read_case(a.input.file, a.input.overrides);
  const Sweep sweep = in_order(sweep_of(a));
  const std::string varied = "numerics." + to_string(sweep.kind);
  for (const std::string& set : a.input.overrides) {
    if (set.starts_with(varied + "="))
      throw ConfigError(fmt::format("--set {}: {} is what the study varies; leave out one of the two", set, varied));
  }
  const Campaign study = planned(a, spec, sweep);
  if (a.campaign.out.empty()) a.campaign.out = fmt::format("out/{}_{}", a.input.file.stem().string(), to_string(sweep.kind));
  a.campaign.plan = a.campaign.out.filename();  // names a job of Slurm
  const std::filesystem::path& out = a.campaign.out;
  require_no_other_files(out, {"converge.csv", "converge.json"}, {"runs"});
  run_campaign(study, a.campaign);

  const std::vector<RunStatus> status = status_of(out, study);
  const std::vector<MetricConvergence> metrics = judged(a, sweep, status);
  write_file(out / "converge.json", converge_json(spec, sweep, study, status, metrics));
  write_converge_table(out / "converge.csv", sweep, metrics);
  print_values(sweep, metrics);
  for (const MetricConvergence& m : metrics) {
    if (a.details || m.exact) print_convergence(m, a.details);
  }
  print_quotes(spec, sweep, metrics);
  fmt::print(stderr, "wrote {} and converge.csv\n", (out / "converge.json").string());
  const auto unknown = [](const MetricConvergence& m) {
    return std::ranges::none_of(m.metric, [](const Metric& x) { return std::isfinite(x.value); });
  };
  if (std::ranges::any_of(metrics, unknown)) throw CLI::RuntimeError(static_cast<int>(ExitCode::failed));
}

}  // namespace

void add_converge(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "converge",
      "Compute a case at several cell sizes (or particles per cell, CFL numbers, offsets against the grid), and estimate the numerical "
      "uncertainty of its metrics: one line for each with the value and the uncertainty to quote; --details: how it was found. The runs "
      "are a campaign (runs/dx0.25, ...), which the same command continues; converge.json and converge.csv are beside them");
  const auto a = std::make_shared<ConvergeArguments>();
  a->campaign.ranks = 1;
  a->campaign.progress = true;
  a->campaign.summary = stderr;
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
  command->add_option("--out", a->campaign.out, "Folder of the study (default: out/<name of the case file>_<what is varied>)")
      ->type_name("DIR");
  add_threads_argument(*command, a->threads);
  add_jobs_argument(*command, a->campaign, "Runs at a time (default: cores over threads a run; Slurm: as many as it grants)");
  add_ranks_argument(*command, a->campaign.ranks, "Processes of each run (default: 1)");
  add_execution_arguments(*command, a->campaign);
  command->callback([a] { converge(*a); });
}

}  // namespace mpm::app
