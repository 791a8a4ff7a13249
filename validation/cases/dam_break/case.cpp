#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/convergence.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation::dam_break {
namespace {

/// Times are multiples of h0/c0, c0 = sqrt(g h0): T = t c0/h0, the ratio of the wave's length to the depth.
constexpr double last_time = 10.0;
constexpr int samples = 40;
constexpr std::array shown_times{2.5, 5.0, 7.5, 10.0};
/// The reservoir is longer than the wave, which outruns c0 t by some (c0 h0^2 t/2)^(1/3) = 1.7 h0 (dispersion of long waves).
constexpr double reservoir = last_time + 4.0;

/// Ritter's solution: h/h0 at xi = x/(c0 t).
double ritter_depth(double xi) { return xi <= -1.0 ? 1.0 : xi >= 2.0 ? 0.0 : (2.0 - xi) * (2.0 - xi) / 9.0; }

Case dam_case(const CaseContext& context, int cells) {
  Case c = context.read_case();
  const double h0 = c.bodies[0].max.z(), dx = h0 / cells;
  c.numerics.cell_size = dx;
  c.bodies[0].min.y() = c.walls[2].point.y() = dx;
  c.bodies[0].max.y() = c.walls[3].point.y() = 2.0 * dx;
  c.bodies[0].min.x() = c.walls[1].point.x() = -reservoir * h0;
  c.domain.min.x() = c.bodies[0].min.x() - h0;
  return c;
}

struct Sample {
  double time;                     ///< T
  double profile_error;            ///< int |h - h_Ritter| dx over h0 c0 t
  double depth_at_gate;            ///< h(0)/h0
  double passed;                   ///< volume beyond x = 0, over h0^2 per width
  double momentum;                 ///< over rho0 g h0^2 t/2 per width
  double foremost;                 ///< x of the foremost particle, h0
  double contour;                  ///< x of h = h0/10, h0
  double front;                    ///< x where the line through sqrt(h), h from h0/10 to 4 h0/10, comes to 0; h0
  std::vector<double> xi, height;  ///< profile: x/(c0 t), h/h0
};

struct Outcome {
  std::vector<Sample> samples;
  double particle_steps = 0.0;
  [[nodiscard]] const Sample& at(double t) const {
    return samples[static_cast<std::size_t>(std::lround(t / last_time * static_cast<double>(samples.size()))) - 1];
  }
  /// Mean rate between two times.
  [[nodiscard]] double rate(double Sample::*what, double t1, double t2) const { return (at(t2).*what - at(t1).*what) / (t2 - t1); }
};

/// x where the line through sqrt(h), for h from h0/10 to 4 h0/10, comes to 0; in h0. 0 with fewer than three points.
double front_of(const DepthProfile& p, double h0, double rho) {
  std::vector<double> x_line, root;
  for (std::size_t k = 0; k < p.mass.size(); ++k) {
    const double h = p.mass[k] / (rho * h0);
    if (h < 0.1 || h > 0.4) continue;
    x_line.push_back(p.x(k) / h0);
    root.push_back(std::sqrt(h));
  }
  if (x_line.size() < 3) return 0.0;
  const Line line = fitted_line(x_line, root);
  return -line.at_zero / line.slope;
}

/// @param t time in h0/c0
Sample measure(const Case& c, const Instant& now, double t) {
  const double h0 = c.bodies[0].max.z(), dx = c.numerics.cell_size, rho = c.material.density(), spacing = 0.25 * h0;
  const DepthProfile p = depth_profile(now.particles, c.bodies[0].min.x(), 3.0 * last_time * h0, spacing, dx);
  Sample s{.time = t};
  for (std::size_t k = 0; k < p.mass.size(); ++k) {
    const double xi = p.x(k) / (t * h0), h = p.mass[k] / (rho * h0);
    s.profile_error += std::abs(h - ritter_depth(xi)) * spacing / (t * h0);
    if (std::abs(p.x(k)) < 1e-9) s.depth_at_gate = h;
    if (xi < -1.5 || xi > 2.2) continue;
    s.xi.push_back(xi);
    s.height.push_back(h);
  }
  s.front = front_of(p, h0, rho);
  s.contour = last_crossing(p, 0.1 * rho * h0).value_or(0.0) / h0;
  double momentum = 0.0;
  for (const ParticleRecord& q : now.particles) {
    momentum += q.mass * q.velocity.x();
    s.foremost = larger(s.foremost, q.position.x() / h0);
    if (q.position.x() > 0.0) s.passed += q.mass / (rho * dx * h0 * h0);
  }
  s.momentum = momentum / (0.5 * rho * c.numerics.gravity * h0 * h0 * dx * now.time);
  return s;
}

Setup dam_setup(const CaseContext& context, int cells) {
  const Case c = dam_case(context, cells);
  const double h0 = c.bodies[0].max.z();
  return {.id = fmt::format("dx{}", cells),
          .title = fmt::format("dam break, dx = h0/{}", cells),
          .spec = c,
          .start = [](const Case& spec, const Scene& scene) { return hydrostatic_state(spec, scene, 0, 2); },
          .times = even_times(0.0, last_time * h0 / std::sqrt(c.numerics.gravity * h0), samples)};
}

std::vector<int> grid_cells(const CaseContext& context) {
  return context.choose<std::vector<int>>({6, 8}, {8, 12, 16, 24}, {8, 12, 16, 24, 32});
}

std::vector<Setup> setups(const CaseContext& context) {
  std::vector<Setup> all;
  for (const int cells : grid_cells(context)) all.push_back(dam_setup(context, cells));
  return all;
}

Outcome run_dam(const CaseContext& context, const Setup& setup, CaseResult* pictures) {
  const Case& c = setup.spec;
  const double h0 = c.bodies[0].max.z();
  Outcome o;
  const RunCost cost = play(context, setup, [&](const Instant& now) {
    const double t = last_time * static_cast<double>(now.index + 1) / samples;
    o.samples.push_back(measure(c, now, t));
    if (pictures != nullptr && now.state != nullptr && now.index + 1 == samples / 4) {
      pictures->flows.push_back(flow_picture(context.directory(), *now.state, *now.scene,
                                             {.id = "speed",
                                              .field = FlowField::speed,
                                              .title = fmt::format("Dam break, t = {} h0/c0", t),
                                              .caption = "The gate stood at x = 0.",
                                              .window = std::array{-4.0 * h0, 5.0 * h0, -0.2 * h0, 1.2 * h0}}));
    }
    return true;
  });
  o.particle_steps = cost.particle_steps;
  return o;
}

/// All grids, coarse first.
struct Grids {
  std::vector<int> cells;  ///< h0/dx
  std::vector<double> size, momentum_error, discharge, profile_error;
  std::vector<Outcome> outcomes;
  double thrust = 1.0;  ///< of the reservoir over that of an incompressible one
  double h0 = 1.0, c0 = 1.0;
  [[nodiscard]] const Outcome& finest() const { return outcomes.back(); }
};

Grids run_grids(const CaseContext& context, CaseResult& result) {
  const Case base = context.read_case();
  const double h0 = base.bodies[0].max.z(), rho = base.material.density(), g = base.numerics.gravity;
  const WeaklyCompressibleFluid::Parameters& water = base.material.as<WeaklyCompressibleFluid>();
  const HydrostaticColumn column(rho, g, tait_curve(water.bulk_modulus, water.tait_exponent));
  Grids grids;
  grids.cells = grid_cells(context);
  grids.h0 = h0;
  grids.c0 = std::sqrt(g * h0);
  grids.thrust = column.thrust(rho * h0) / (0.5 * rho * g * h0 * h0);
  double particle_steps = 0.0;
  for (const int cells : grids.cells) {
    const Setup setup = dam_setup(context, cells);
    const Case& c = setup.spec;
    const Outcome& o = grids.outcomes.emplace_back(run_dam(context, setup, cells == grids.cells.back() ? &result : nullptr));
    particle_steps += o.particle_steps;
    grids.size.push_back(c.numerics.cell_size / h0);
    grids.momentum_error.push_back(std::abs(o.at(5.0).momentum / grids.thrust - 1.0));
    grids.discharge.push_back(o.rate(&Sample::passed, 5.0, last_time));
    grids.profile_error.push_back(o.at(last_time).profile_error);
    context.log(
        fmt::format("h0/dx = {}: momentum {:.4f} of theory, discharge {:.4f}, profile error {:.4f}, front {:.4f}; {:.3g} particle-steps",
                    cells, o.at(5.0).momentum / grids.thrust, grids.discharge.back() * 27.0 / 8.0, grids.profile_error.back(),
                    o.rate(&Sample::front, 5.0, last_time) / 2.0, o.particle_steps));
  }
  result.notes.push_back(fmt::format("{:.2g} particle-steps in all.", particle_steps));
  return grids;
}

void check(CaseResult& result, const Grids& grids) {
  const Outcome& finest = grids.finest();
  Check& momentum =
      result.check_relative(Label::verification, "momentum at t = 5 h0/c0 over the thrust of the reservoir times t",
                            finest.at(5.0).momentum, grids.thrust, "", std::min(grids.size.back(), 1.0 / 12.0) / 4.0,
                            "the cell at the floor carries 1/8 too much stress, which is dx/(4 h0) of the thrust (see hydrostatic_column); "
                            "never more than at h0/12");
  momentum.observed_order = fitted_order(grids.size, grids.momentum_error);
  result.check_order(Label::verification, "order of the momentum in dx", *momentum.observed_order, 0.8, 4.0,
                     "at least first order at the floor; more where the floor is not held at nodes");
  double gate = 0.0, weight = 0.0;
  for (const Sample& s : finest.samples) {
    if (s.time < 7.5) continue;
    gate += s.depth_at_gate;
    weight += 1.0;
  }
  const Sample& end = finest.at(last_time);
  const double shift = 1.0 / last_time;  // a displacement of one depth over the distance c0 t
  result
      .check_relative(Label::verification, "depth at the gate, mean from t = 7.5 to 10 h0/c0", gate / weight, 4.0 / 9.0, "h0", 0.5 / 8.75,
                      "displacement by half a depth in the early stage, which is not hydrostatic: δh/h = δx/(c0 t)")
      .in_summary(Quantity::depth, 0.0, grids.h0);
  Check& rate = result.check_relative(
      Label::verification, "discharge past the gate from t = 5 to 10 h0/c0", grids.discharge.back(), 8.0 / 27.0, "h0 c0", 0.014,
      "vertical acceleration raises the pressure at the gate by 0.33 (h0/(c0 t))², 0.7 % in the mean; doubled");
  result.check_absolute(Label::verification, "profile at t = 10 h0/c0, L1 error over h0 c0 t", end.profile_error, 0.0, "", 0.5 * shift,
                        "displacement by half a depth δx: ∫|dh/dx| δx dx = h0 δx");
  result
      .check_relative(Label::verification, "speed of the front (√h continued to 0) from t = 5 to 10 h0/c0",
                      finest.rate(&Sample::front, 5.0, last_time), 2.0, "c0", shift,
                      "displacement by half a depth while the wave goes on by 5 h0")
      .in_summary(Quantity::speed, 0.0, grids.c0);
  if (grids.size.size() >= 3) {
    const Convergence d = judge_convergence(grids.size, grids.discharge, 1.0), p = judge_convergence(grids.size, grids.profile_error, 1.0);
    rate.observed_order = d.order;
    result.convergences.push_back({"discharge past the gate from t = 5 to 10 h0/c0", "h0 c0", d, "dx/h0 [-]"});
    result.convergences.push_back({"profile at t = 10 h0/c0, L1 distance from Ritter over h0 c0 t", "", p, "dx/h0 [-]"});
  }
  std::vector<double> aspect_size, aspect_error;
  for (const double t : shown_times) {
    aspect_size.push_back(1.0 / t);
    aspect_error.push_back(finest.at(t).profile_error);
  }
  result.check_order(Label::verification, "order of the profile's error in the aspect h0/(c0 t)", fitted_order(aspect_size, aspect_error),
                     0.6, 1.1, "1 for a displacement that stays; 2/3 for one that grows with the width of dispersion, t^(1/3)");
}

/// What was seen at the times that are shown.
void add_notes(CaseResult& result, const Grids& grids) {
  for (const double t : shown_times) {
    const Sample& s = grids.finest().at(t);
    result.notes.push_back(fmt::format(
        "dx = h0/{}, t = {} h0/c0: profile off by {:.2f} % of h0 c0 t, depth at the gate {:.4f} h0 (4/9 = 0.4444), {:.2f} % of Ritter's "
        "volume past the gate, h = h0/10 at {:.2f} h0 ({:.2f}), front at {:.2f} h0, foremost particle at {:.2f} h0 ({:.2f}).",
        grids.cells.back(), t, 100.0 * s.profile_error, s.depth_at_gate, 100.0 * s.passed / (8.0 / 27.0 * t), s.contour,
        (2.0 - 3.0 * std::sqrt(0.1)) * t, s.front, s.foremost, 2.0 * t));
  }
  result.notes.push_back(fmt::format("Not asserted: the foremost particle runs at {:.3f} c0 between t = 5 and 10 h0/c0; see the README.",
                                     grids.finest().rate(&Sample::foremost, 5.0, last_time)));
}

Plot profile_plot(const Grids& grids) {
  Plot profile{"profile", "Depth, in Ritter's similarity variable", "x/(c0 t) [-]", "h/h0 [-]"};
  profile.series.push_back(reference_curve("Ritter", -1.5, 2.2, 74, ritter_depth));
  for (const double t : shown_times) {
    const Sample& s = grids.finest().at(t);
    profile.series.push_back({fmt::format("t = {} h0/c0", t), s.xi, s.height, Series::Style::simulation});
  }
  profile.caption =
      fmt::format("dx = h0/{}. The waves are long against the depth only for t c0/h0 >> 1: Ritter is the limit.", grids.cells.back());
  return profile;
}

/// Distance from Ritter's profile over time, and its slope.
Plot aspect_plot(const Grids& grids) {
  Plot plot{"aspect", "Distance from Ritter's profile", "t c0/h0 [-]", "∫|h - h_Ritter| dx / (h0 c0 t) [-]", {}, "", true, true};
  for (std::size_t i = 0; i < grids.cells.size(); ++i) {
    Series fall{fmt::format("dx = h0/{}", grids.cells[i]), {}, {}, Series::Style::points};
    for (const Sample& s : grids.outcomes[i].samples) {
      if (s.time < 1.0) continue;
      fall.x.push_back(s.time);
      fall.y.push_back(s.profile_error);
    }
    plot.series.push_back(std::move(fall));
  }
  Series slope{"order 1 in h0/(c0 t)", {1.0, last_time}, {}, Series::Style::bound};
  for (const double t : slope.x) slope.y.push_back(grids.profile_error.back() * last_time / t);
  plot.series.push_back(std::move(slope));
  return plot;
}

Plot front_plot(const Grids& grids) {
  Plot plot{"front", "Front", "t c0/h0 [-]", "x/h0 [-]"};
  plot.caption = "Front: where the line through √h, h from 0.1 to 0.4 h0, comes to 0.";
  plot.series.push_back({"Ritter, 2 c0 t", {0.0, last_time}, {0.0, 2.0 * last_time}, Series::Style::reference});
  for (std::size_t i = 0; i < grids.cells.size(); ++i) {
    Series path{fmt::format("dx = h0/{}", grids.cells[i]), {}, {}, Series::Style::simulation};
    Series foremost{path.name + ", foremost particle", {}, {}, Series::Style::points};
    for (const Sample& s : grids.outcomes[i].samples) {
      path.x.push_back(s.time);
      path.y.push_back(s.front);
      foremost.y.push_back(s.foremost);
    }
    foremost.x = path.x;
    plot.series.push_back(std::move(path));
    if (i + 1 == grids.cells.size()) plot.series.push_back(std::move(foremost));
  }
  return plot;
}

void run(const CaseContext& context, CaseResult& result) {
  const Grids grids = run_grids(context, result);
  check(result, grids);
  add_notes(result, grids);
  result.plots = {profile_plot(grids), aspect_plot(grids), front_plot(grids)};
  result.plots.push_back({"momentum-order",
                          "Error of the momentum at t = 5 h0/c0",
                          "dx/h0 [-]",
                          "relative error [-]",
                          {slope_line("order 1", grids.size, grids.momentum_error.back(), 1.0),
                           {"simulation", grids.size, grids.momentum_error, Series::Style::points}},
                          "",
                          true,
                          true});
}

const Registration registered{{.title = "Dam break over a dry bed (Ritter)", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::dam_break
