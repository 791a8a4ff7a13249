#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "validation/harness/impact.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/scores.hpp"

namespace mpm::validation::avalanche {
namespace {

/// A flow and its grid.
struct Point {
  double froude, slope, cohesion;  ///< Fr, M, beta
  double duration, cell_size;      ///< s, m
};

/// Full width of a channel over that of the mast, where the flow is faster than its waves: its side walls are not felt at the mast.
constexpr double narrow = 6.0;

/// Mean of the pressure coefficient on the stagnation line of a plate of half width a, from the plate to a distance l upstream, over its
/// value at the plate: potential flow gives c_p(d) = a^2/(d^2 + a^2), so the mean is (a/l) atan(l/a).
double stagnation_line_mean(double a, double l) { return a / l * std::atan(l / a); }

/// Chosen by a rule, before any of them was run: see the README.
std::vector<Point> points(const CaseContext& context) {
  const double creeping = context.choose(18.0, 18.0, 20.0);  // s: the pile takes some 12 s to form
  const double slow = context.choose(0.35, 0.35, 0.25), fast = context.choose(0.4375, 0.25, 0.25);
  const Point loose[] = {{0.3, 0.4, 0.0, creeping, slow}, {1.0, 0.4, 0.0, 7.0, fast}, {5.0, 0.4, 0.0, 7.0, fast}};
  const Point sticky[] = {{0.3, 0.8, 0.3, creeping, slow}, {1.0, 0.8, 0.3, 7.0, fast}, {5.0, 0.8, 0.3, 7.0, fast}};
  if (context.level() == Level::quick) return {{1.0, 0.4, 0.0, 3.5, fast}};
  return {loose[0], sticky[0], loose[1], sticky[1], loose[2], sticky[2]};
}

Case case_of(const CaseContext& context, const Point& point) {
  Case c = context.read_case();
  c.conveyor->velocity = flow_velocity(point.froude, c.conveyor->flow_height, c.numerics.gravity);
  c.material.as<mpm::CamClay>().critical_state_slope = point.slope;
  c.material.as<mpm::CamClay>().cohesion_beta = point.cohesion;
  c.numerics.cell_size = point.cell_size;
  c.output.duration = point.duration;
  return c;
}

/// Runs it and compares run-up and pressure height with the paper's equations.
ImpactRun judge(const CaseContext& context, const std::string& id, const std::string& name, const Case& c, CaseResult& result) {
  ImpactRun run = run_impact(context, id, name, c);
  result.check_absolute(Label::verification, name + ": a steady span is found (1: yes)", run.steady() ? 1.0 : 0.0, 1.0, "", 0.0,
                        "without one there are no means");
  result
      .check_relative(Label::validation, name + ": steady run-up", run.value("runup_mean_m"), run.value("predicted_runup_m"), "m", 0.20,
                      "aim of the project; the paper's regression scatters by 13 % (RMSLE) and the mast's friction is not printed there")
      .in_summary(Quantity::run_up, paper_runup_scatter);
  result
      .check_relative(Label::validation, name + ": steady pressure height", run.value("pressure_height_mean_m"),
                      run.value("predicted_pressure_height_m"), "m", 0.15,
                      "aim of the project; of the paper's own points 85 % lie within 10 %, all within 25 %")
      .in_summary(Quantity::pressure_height, paper_pressure_height_scatter);
  result.notes.push_back(run_note(run));
  result.plots.push_back(runup_plot(run));
  result.plots.push_back(profile_plot(run, run.value("pressure_height_mean_m")));
  return run;
}

/// The equations as coded against the table of reference_data, which was computed independently.
void equations_against_table(const CaseContext& context, const std::vector<ImpactRun>& runs, CaseResult& result) {
  const Table table = Table::read(context.case_directory() / "../../../reference_data/paper_semiempirical_predictions/data.csv");
  const auto friction = table.numbers("Mprime"), froude = table.numbers("Fr");
  const auto runup = table.numbers("hr_over_H_A"), height = table.numbers("hp_over_H_A");
  double largest = 0.0;
  for (const ImpactRun& run : runs) {
    const double m = effective_friction(run.spec.material.as<mpm::CamClay>().critical_state_slope,
                                        run.spec.material.as<mpm::CamClay>().cohesion_beta),
                 h = run.flow_height();
    const double fr = froude_number(run.spec.conveyor->velocity, h);
    double error = 1.0;  // a point that the table lacks
    for (std::size_t i = 0; i < friction.size(); ++i) {
      if (std::abs(friction[i] - m) > 1e-6 || std::abs(froude[i] - fr) > 1e-9) continue;
      error = std::max(std::abs(run.value("predicted_runup_m") / h / runup[i] - 1.0),
                       std::abs(run.value("predicted_pressure_height_m") / h / height[i] - 1.0));
    }
    largest = larger(largest, error);
  }
  result.check_absolute(Label::verification, "the equations as coded against the table in reference_data, largest relative difference",
                        largest, 0.0, "", 1e-5, "M' is rounded to 6 decimals in the table; at Fr 5 the height changes by 20 times that");
}

/// Heights over Fr: the equation for each snow, the simulated means.
Plot heights_over_froude(const std::vector<ImpactRun>& runs, bool pressure) {
  Plot plot{pressure ? "pressure-height-over-fr" : "runup-over-fr",
            pressure ? "Pressure height against the paper's equation" : "Run-up against the paper's equation",
            "Froude number",
            pressure ? "pressure height / H" : "run-up / H",
            {},
            "",
            true,
            !pressure};
  std::vector<double> fr{0.1};
  while (fr.back() * 1.05 < 7.05) fr.push_back(fr.back() * 1.05);
  std::vector<double> done;
  for (const ImpactRun& first : runs) {
    const double h = first.flow_height();
    const auto friction_of = [](const ImpactRun& r) {
      return effective_friction(r.spec.material.as<mpm::CamClay>().critical_state_slope, r.spec.material.as<mpm::CamClay>().cohesion_beta);
    };
    const double friction = friction_of(first);
    if (std::ranges::find(done, friction) != done.end()) continue;
    done.push_back(friction);
    Series line{fmt::format("equation, M' {:.3g}", friction), fr, {}, Series::Style::reference};
    for (const double f : fr) {
      const double v = flow_velocity(f, h);
      line.y.push_back((pressure ? predicted_pressure_height(friction, v, h) : predicted_runup(friction, v, h)) / h);
    }
    Series simulated{fmt::format("simulation, M' {:.3g}", friction), {}, {}, Series::Style::points};
    for (const ImpactRun& run : runs) {
      if (friction_of(run) != friction) continue;
      simulated.x.push_back(froude_number(run.spec.conveyor->velocity, h));
      simulated.y.push_back((pressure ? run.value("pressure_height_mean_m") : run.value("runup_mean_m")) / h);
    }
    plot.series.push_back(line);
    plot.series.push_back(simulated);
  }
  if (!pressure) {
    Series bound{"1 + Fr²/2", fr, {}, Series::Style::bound};
    for (const double f : fr) bound.y.push_back(1.0 + 0.5 * f * f);
    plot.series.push_back(bound);
  }
  return plot;
}

/// A frictionless mast takes momentum by pressure alone: the pressure measured before its face must then be the force.
ImpactRun pressure_against_force(const CaseContext& context, CaseResult& result) {
  Case c = case_of(context, {3.0, 0.4, 0.0, context.choose(4.4, 5.0, 5.0), context.choose(0.35, 0.25, 0.25)});
  c.obstacle->friction = 0.0;
  c.conveyor->width = narrow * c.obstacle->width();
  c.conveyor->downstream_length = 2.8;
  ImpactRun run = judge(context, "frictionless", "Fr 3, M' 0.4, frictionless mast", c, result);
  const double force = run.value("force_mean_n");
  result
      .check_relative(Label::verification, "frictionless mast: pressure before the face against the force", run.value("profile_force_n"),
                      force, "N", 0.15, "aim of the project")
      .known_miss(context.choose(0.735, 0.805, 0.805) * force,
                  "the box in which the pressure is measured reaches 2.5 cells upstream, where the pressure is lower than on the face");
  const double fraction = stagnation_line_mean(0.5 * c.obstacle->width(), 2.5 * c.numerics.cell_size);
  result.check_relative(Label::verification, "frictionless mast: pressure before the face, made up for the box depth, against the force",
                        run.value("profile_force_n") / fraction, force, "N", 0.15,
                        "the strip |y| <= 3w/7 represents the whole face, and potential flow the jet; 15 %: aim of the project");
  return run;
}

void run(const CaseContext& context, CaseResult& result) {
  std::vector<ImpactRun> runs;
  std::vector<double> runup, predicted_runup, height, predicted_height;
  for (const Point& point : points(context)) {
    const double friction = effective_friction(point.slope, point.cohesion);
    runs.push_back(judge(context, fmt::format("fr{:g}-m{:g}-b{:g}", point.froude, point.slope, point.cohesion),
                         fmt::format("Fr {:g}, M' {:.3g}", point.froude, friction), case_of(context, point), result));
    const ImpactRun& last = runs.back();
    if (!last.steady()) continue;
    runup.push_back(last.value("runup_mean_m"));
    predicted_runup.push_back(last.value("predicted_runup_m"));
    height.push_back(last.value("pressure_height_mean_m"));
    predicted_height.push_back(last.value("predicted_pressure_height_m"));
  }
  if (runup.size() > 1) {
    const Scores of_runup = compute_scores(runup, predicted_runup), of_height = compute_scores(height, predicted_height);
    result.check_at_most(Label::validation, fmt::format("RMSLE of the {} run-ups", runup.size()), of_runup.rmsle, 0.15, "", 0.0,
                         "aim of the project; the paper's own, of its fit to its own 371 simulations, is 0.13");
    result.notes.push_back(
        fmt::format("Run-up: RMSLE {:.3f}, bias {:.3f} (paper, in sample: 0.130, 0.981). Pressure height: NRMSE {:.3f}, "
                    "RMSLE {:.3f}, bias {:.3f} (paper: NRMSE 0.066, bias 1.011).",
                    of_runup.rmsle, of_runup.bias, of_height.nrmse, of_height.rmsle, of_height.bias));
  }
  runs.push_back(pressure_against_force(context, result));
  equations_against_table(context, runs, result);
  result.plots.insert(result.plots.begin(), {heights_over_froude(runs, false), heights_over_froude(runs, true)});
  for (const ImpactRun& r : runs) {
    const double top = 1.3 * r.value("runup_peak_m");
    result.flows.push_back(last_picture(
        r, FlowField::stress_xx, {-r.spec.conveyor->upstream_length, 2.0 * r.flow_height(), -0.2, std::min(top, 8.0 * r.flow_height())}));
  }
}

const Registration registered{{.title = "Avalanche on a mast", .run = run}};

}  // namespace
}  // namespace mpm::validation::avalanche
