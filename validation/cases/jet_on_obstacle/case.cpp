#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation::jet_on_obstacle {
namespace {

// Times are multiples of b/v, half the jet's thickness over its speed: measured from `from` to `to`.
constexpr double from = 10.0, to = 26.0, nearest = 1.0;
constexpr std::size_t batches = 8, before = 80, samples = 320;

/// One obstacle, and the force on it by the momentum theorem, over rho0 v^2 A.
struct Target {
  std::string id, name;
  ObstacleSpec obstacle;
  double force_x, force_y;
  double aim;  ///< largest excess of the force along the jet that a sharp edge may add at dx = b/4, over the exact force; 0 for a face
};

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

/// Flanks of 8 b at `half_angle` to the jet, which leaves along them: 1 - cos.
Target wedge(double b, double degrees, double aim) {
  const ObstacleSpec o{.shape = WedgeShape{.width = 16.0 * b * std::sin(radians(degrees)), .depth = 8.0 * b * std::cos(radians(degrees))}};
  return {fmt::format("wedge-{:.0f}", degrees),
          fmt::format("wedge, half angle {:.0f}°", degrees),
          o,
          1.0 - std::cos(radians(degrees)),
          0.0,
          aim};
}

/// A box whose front face, 16 b wide, is turned by `degrees`: the face takes the momentum normal to it, cos of the jet's, along its normal.
Target plate(double b, double degrees) {
  const ObstacleSpec o{.shape = BoxShape{.width = 16.0 * b, .depth = 2.0 * b, .rotation = radians(degrees)}};
  const double c = std::cos(radians(degrees)), s = std::sin(radians(degrees));
  return {fmt::format("face-{:.0f}", degrees), fmt::format("face turned by {:.0f}°", degrees), o, c * c, c * s, 0.0};
}

Target cylinder(double b) {
  const ObstacleSpec o{.shape = CylinderShape{.width = 8.0 * b}};
  return {"cylinder", "cylinder, radius 4 b", o, std::nan(""), 0.0, 0.0};
}

struct Measured {
  BatchMean force_x{}, force_y{};  ///< over rho0 v^2 A
  std::vector<double> time, history;
  double particle_steps = 0.0;
};

std::vector<Target> targets(double b) { return {wedge(b, 30.0, 0.15), wedge(b, 45.0, 0.06), plate(b, 30.0), plate(b, 45.0), cylinder(b)}; }

std::vector<int> grid_cells(const CaseContext& context) { return context.choose<std::vector<int>>({2, 4}, {2, 4, 6, 8}, {2, 4, 6, 8, 12}); }

Setup jet_setup(const Case& base, const Target& target, int cells) {
  Case c = base;
  const double b = c.bodies[0].max.y(), v = c.bodies[0].velocity.x(), dx = b / cells;
  c.obstacle = target.obstacle;
  c.obstacle->friction = 0.0;
  // y of the point of the front that is met in the middle: the front of the turned face is not centred on its leading corner
  const double leading_x = outline_of(c.obstacle->shape).section(0.0).value().low;
  c.numerics.cell_size = dx;
  c.walls[0].point.z() = c.bodies[0].min.z() = dx;
  c.walls[1].point.z() = c.bodies[0].max.z() = 2.0 * dx;
  c.bodies[0].max.x() = -nearest * b;
  c.bodies[0].min.x() = -(to + 6.0) * b;
  c.domain.min = Vec3(c.bodies[0].min.x() - b, -7.0 * b, 0.0);
  c.domain.max = Vec3(leading_x + 6.0 * b, 7.0 * b, 1.0);
  const double unit = b / v;
  std::vector<double> times = even_times(0.0, from * unit, before);
  std::ranges::copy(even_times(from * unit, to * unit, samples), std::back_inserter(times));
  return {.id = fmt::format("{}-dx{}", target.id, cells),
          .title = fmt::format("{}, dx = b/{}", target.name, cells),
          .spec = std::move(c),
          .start = [](const Case& spec, const Scene& scene) { return staggered_state(spec, scene, 1, 0); },
          .times = std::move(times),
          .particles = false,
          .forces = true};
}

std::vector<Setup> setups(const CaseContext& context) {
  const Case base = context.read_case();
  std::vector<Setup> all;
  for (const Target& target : targets(base.bodies[0].max.y()))
    for (const int cells : grid_cells(context)) all.push_back(jet_setup(base, target, cells));
  return all;
}

Measured run_jet(const CaseContext& context, const Setup& setup) {
  const Case& c = setup.spec;
  const double b = c.bodies[0].max.y(), v = c.bodies[0].velocity.x(), unit = b / v,
               full = c.material.density() * v * v * 2.0 * b * c.numerics.cell_size;
  Measured m;
  std::vector<double> x, y;
  const RunCost cost = play(context, setup, [&](const Instant& now) {
    const Vec3 force = now.forces.back() / full;  // the obstacle's
    m.time.push_back(0.5 * (now.before + now.time) / unit);
    m.history.push_back(force.x());
    if (now.index >= before) {
      x.push_back(force.x());
      y.push_back(force.y());
    }
    return true;
  });
  m.particle_steps = cost.particle_steps;
  m.force_x = batch_mean(x, batches);
  m.force_y = batch_mean(y, batches);
  return m;
}

void run(const CaseContext& context, CaseResult& result) {
  const Case base = context.read_case();
  const double b = base.bodies[0].max.y();
  const auto grids = grid_cells(context);
  Plot plot{"force", "Force on the obstacle along the jet", "time [b/v]", "force / (ρ0 v² A) [-]"};
  for (const Target& target : targets(b)) {
    std::vector<double> size, force, error;
    Measured m;
    for (const int cells : grids) {
      m = run_jet(context, jet_setup(base, target, cells));
      size.push_back(b / cells);
      force.push_back(m.force_x.mean);
      error.push_back(m.force_x.standard_error);
      const std::string line = fmt::format(
          "{}, dx = b/{}: force {:.4f} ({:.4f}) along the jet, {:.4f} ({:.4f}) across, over ρ0v²A; momentum theorem {:.4f}, {:.4f}",
          target.name, cells, m.force_x.mean, m.force_x.standard_error, m.force_y.mean, m.force_y.standard_error, target.force_x,
          target.force_y);
      context.log(fmt::format("{}; {:.2g} particle-steps", line, m.particle_steps));
      result.notes.push_back(line + ".");
    }
    const double v = base.bodies[0].velocity.x(), full = base.material.density() * v * v * 2.0 * b;  // N, of a jet one metre wide
    if (target.aim > 0.0) {
      std::vector<double> excess;
      for (const double f : force) excess.push_back(std::abs(f - target.force_x));
      // statistical error of the order between the coarsest and the finest grid
      const double doubt = std::hypot(error.front() / excess.front(), error.back() / excess.back()) / std::log(size.front() / size.back());
      result
          .check_relative(Label::verification, target.name + ": force along the jet over ρ0v²A", m.force_x.mean, target.force_x, "",
                          target.aim * 4.0 * size.back() / b,
                          "aim at dx = b/4: 15 % at 30°, 6 % at 45°; on other grids in proportion to dx: the edge is blunt by a cell")
          .in_summary(Quantity::force, 0.0, full)
          .observed_order = fitted_order(size, excess);
      Check& order = result.check_order(Label::verification, target.name + ": order of that excess", fitted_order(size, excess),
                                        0.8 - 2.0 * doubt, 4.0, "first order; the edge is a smaller part of the jet the finer the grid");
      if (target.name == "wedge, half angle 45°" && context.level() == Level::quick)
        order.known_miss(
            0.10, "at dx = b/2 the margin at the trailing edges takes off what the blunt edge adds: the excess is as small as at b/4");
    } else if (std::isfinite(target.force_x)) {
      const std::string reason = "what the sheets have not yet turned at 6 b; three standard errors of the time mean";
      result
          .check_absolute(Label::verification, target.name + ": force along the jet over ρ0v²A", m.force_x.mean, target.force_x, "",
                          0.002 + 3.0 * m.force_x.standard_error, reason)
          .in_summary(Quantity::force, 0.0, full);
      result
          .check_absolute(Label::verification, target.name + ": force across the jet over ρ0v²A", m.force_y.mean, target.force_y, "",
                          0.002 + 3.0 * m.force_y.standard_error, reason)
          .in_summary(Quantity::force, 0.0, full);
    }
    plot.series.push_back({target.name, m.time, m.history, Series::Style::simulation});
    if (size.size() >= 3)
      result.convergences.push_back({target.name + ": force along the jet", "ρ0v²A", judge_convergence(size, force, 1.0)});
  }
  result.plots.push_back(std::move(plot));
}

const Registration registered{{.title = "A plane jet on a wedge, a turned face and a cylinder", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::jet_on_obstacle
