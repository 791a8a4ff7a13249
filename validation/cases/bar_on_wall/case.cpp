#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/particle_access.hpp"
#include "validation/harness/slender.hpp"

namespace mpm::validation {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double slow = 1e-6;  ///< v/c: strains of 1e-6, so that the exact solution is the linear one

/// How the bar moves at first; v is V times this, over its length.
enum class Start {
  uniform,  ///< towards the wall everywhere: a shock
  smooth,   ///< towards the wall, as sin^4(pi x / 2 L)
  pulled,   ///< away from it, as sin^4(pi x / 2 L)
};

struct Settings {
  Start start = Start::smooth;
  int cells = 32;       ///< per L
  double offset = 0.0;  ///< of the wall and the bar against the grid, cells
  ContactRule contact = ContactRule::surface;
  Transfer transfer = Transfer::aflip;
  double flip_ratio = 1.0;
  double gap = 0.0;       ///< between the bar and the wall at first, cells
  double speed = slow;    ///< V/c
  double duration = 3.0;  ///< L/c
};

/// What happened, in units of L/c (time), rho c V A (force), the bar's mass times V (momentum) and m V^2/2 (energy).
struct Impact {
  double cell = 0.0;                ///< over L
  std::vector<double> time, force;  ///< of each step
  std::vector<double> momentum;     ///< after each step, away from the wall
  std::vector<double> energy_time, energy;
  double impulse = 0.0;        ///< that the wall gave in all
  double largest_pull = 0.0;   ///< largest force of a step towards the wall
  double balance = 0.0;        ///< largest difference between a step's change of momentum and the wall's impulse
  double turning_point = 0.0;  ///< of the centre of mass, over L: where it is nearest to the wall
};

double shape(Start start, double x) { return start == Start::uniform ? 1.0 : std::pow(std::sin(0.5 * pi * x), 4); }
double shape_slope(Start start, double x) {
  return start == Start::uniform ? 0.0 : 2.0 * pi * std::pow(std::sin(0.5 * pi * x), 3) * std::cos(0.5 * pi * x);
}
/// The force of the exact solution over rho c V A, t in L/c: d'Alembert, derived in the README.
double exact_force(Start start, double t) {
  if (start == Start::pulled || t <= 0.0 || t >= 2.0) return 0.0;
  return shape(start, t);  // sin^4 is even about x = L
}

Impact hit(const CaseContext& context, const Settings& s) {
  Case c = context.read_case();
  const double length = c.bodies[0].max.x(), dx = length / s.cells, side = 0.5 * dx;
  c.numerics.cell_size = dx;
  c.numerics.contact = s.contact;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = s.flip_ratio;
  c.numerics.grid_offset = Vec3(s.offset, 0.0, 0.0);
  c.bodies[0].min.x() = s.gap * dx;
  c.bodies[0].max.x() += s.gap * dx;
  c.bodies[0].velocity.setZero();
  set_side(c, side, {1, 2});
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const double speed = wave_speed_of(scene.material), v = s.speed * speed, density = density_of(scene.material);
  const double sign = s.start == Start::pulled ? 1.0 : -1.0;
  state.grid.change_particles([&](Particle& p) {
    const double x = (p.position[0] - scene.offset.x()) / length - s.gap / s.cells;
    p.velocity[0] = sign * v * shape(s.start, x);
    p.affine[0] = sign * v * shape_slope(s.start, x) / length;
  });

  Impact r;
  r.cell = 1.0 / s.cells;
  const double unit = length / speed, dt = unit / std::ceil(s.cells / c.numerics.cfl), mass = density * length * side * side;
  const double full = density * speed * v * side * side;
  double elastic = 0.0, kinetic = -1.0, before = totals(state, scene).momentum.x();
  double centre = (0.5 * length + s.gap * dx) / length;
  r.turning_point = centre;
  const auto steps = static_cast<int>(std::lround(s.duration * unit / dt));
  for (int n = 0; n < steps; ++n) {
    const StepReport report = step(state, scene, dt);
    const Totals now = totals(state, scene);
    const double given = -report.impulses[0].linear.x();  // to the bar, away from the wall
    r.time.push_back(n * dt / unit);                      // stresses of the step's start act in it
    r.force.push_back(given / (dt * full));
    r.momentum.push_back(now.momentum.x() / (mass * v));
    r.impulse += given / (mass * v);
    r.largest_pull = std::max(r.largest_pull, -given / (dt * full));
    r.balance = std::max(r.balance, std::abs(now.momentum.x() - before - given) / (mass * v));
    before = now.momentum.x();
    centre += dt * before / (mass * length);
    r.turning_point = std::min(r.turning_point, centre);
    // velocities live at half steps: their energies before and after a stress are averaged
    const double moving = now.kinetic_energy + now.affine_energy;
    if (kinetic >= 0.0) {
      r.energy_time.push_back(n * dt / unit);
      r.energy.push_back((elastic + 0.5 * (kinetic + moving)) / (0.5 * mass * v * v));
    }
    kinetic = moving;
    elastic = now.elastic_energy;
  }
  return r;
}

struct Variant {
  std::string name;
  Settings settings;
};

/// Contact at the surface; transfers, and places of the wall between two nodes.
std::vector<Variant> surface_variants() {
  return {{"AFLIP, wall on nodes", {}},
          {"AFLIP, wall a quarter of a cell off the nodes", {.offset = 0.25}},
          {"AFLIP, wall half a cell off the nodes", {.offset = 0.5}},
          {"AFLIP, wall three quarters of a cell off the nodes", {.offset = 0.75}},
          {"APIC, wall on nodes", {.transfer = Transfer::apic}},
          {"FLIP, wall on nodes", {.transfer = Transfer::flip}}};
}
Variant nodal_variant() { return {"contact on nodes, APIC", {.contact = ContactRule::nodal, .transfer = Transfer::apic}}; }

/// The same on all grids.
struct Sweep {
  std::vector<double> cell;
  std::vector<Impact> impacts;
};
Sweep sweep(const CaseContext& context, Settings s, Start start, const std::vector<int>& grids) {
  Sweep r;
  s.start = start;
  for (const int cells : grids) {
    s.cells = cells;
    r.impacts.push_back(hit(context, s));
    r.cell.push_back(1.0 / cells);
  }
  return r;
}

/// Root mean square error of the force over 3 L/c, over the largest exact force.
double force_error(const Impact& r, Start start) {
  double squares = 0.0;
  for (std::size_t i = 0; i < r.time.size(); ++i) squares += std::pow(r.force[i] - exact_force(start, r.time[i]), 2);
  return std::sqrt(squares / static_cast<double>(r.time.size()));
}
/// Mean of |error| of the force over 3 L/c.
double force_l1(const Impact& r, Start start) {
  double sum = 0.0;
  for (std::size_t i = 0; i < r.time.size(); ++i) sum += std::abs(r.force[i] - exact_force(start, r.time[i]));
  return sum / static_cast<double>(r.time.size());
}

/// Width over L of a front that has run over twice the length, from the dispersion of the scheme: f/f_exact - 1 = -b (k dx)^2 (case
/// elastic_wave) gives (3 b dx^2 2 L)^(1/3).
double front_width(double cell, Transfer transfer) {
  const double b = transfer == Transfer::apic ? 0.1076 : 0.1076 + 0.125;
  return std::cbrt(6.0 * b * cell * cell);
}

void check_exact_properties(CaseResult& result, const std::vector<const Impact*>& all) {
  double pull = 0.0, balance = 0.0, gain = 0.0;
  for (const Impact* r : all) {
    pull = std::max(pull, r->largest_pull);
    balance = std::max(balance, r->balance);
    for (const double e : r->energy) gain = std::max(gain, e / r->energy.front() - 1.0);
  }
  const std::string runs = fmt::format("{} runs", all.size());
  result.check_at_most(Label::verification, "largest force of a step that pulls the bar towards the wall, over ρcVA, " + runs, pull, 0.0,
                       "", 1e-12, "a separable wall cannot pull: round-off");
  result.check_at_most(Label::verification, "change of momentum in a step minus the wall's impulse, over mV, " + runs, balance, 0.0, "",
                       1e-12, "round-off of sums over particles and nodes");
  result.check_at_most(Label::verification, "gain of energy over the energy at first, largest of all instants, " + runs, gain, 0.0, "",
                       0.01,
                       "a wall at rest does no work; the mean of the kinetic energies of two half steps differs from that between them by "
                       "(ω dt)²/4, which is 1 % of the energy at wavelengths of 12 cells and CFL 0.4");
}

void smooth_impact(const CaseContext& context, CaseResult& result, const std::vector<int>& grids, std::vector<Impact>& kept) {
  Plot errors{
      "smooth-error", "Smooth impact: error of the force", "dx / L [-]", "root mean square error over ρcVA [-]", {}, "", true, true};
  Plot history{"smooth", "Smooth impact on the coarsest grid", "time [L/c]", "force / ρcVA [-]", {}, "", false, false};
  Series exact{"exact", {}, {}, Series::Style::reference};
  for (int i = 0; i <= 300; ++i) exact.x.push_back(0.01 * i), exact.y.push_back(exact_force(Start::smooth, 0.01 * i));
  history.series.push_back(exact);
  std::vector<Variant> variants = surface_variants();
  variants.push_back(nodal_variant());
  for (const Variant& variant : variants) {
    const bool surface = variant.settings.contact == ContactRule::surface;
    const Sweep s = sweep(context, variant.settings, Start::smooth, grids);
    std::vector<double> error, loss;
    for (const Impact& r : s.impacts) {
      error.push_back(force_error(r, Start::smooth));
      loss.push_back(std::abs(r.energy.back() / r.energy.front() - 1.0));
    }
    const double order = fitted_order(s.cell, error);
    if (surface) {
      result
          .check_order(Label::verification, "smooth impact, contact at the surface, " + variant.name + ": order of the force", order, 1.8,
                       2.6, "second order is the aim; up to 2.6 because the wave is 16 cells long on the coarsest grid")
          .observed_order = order;
    } else {
      result
          .check_order(Label::verification, "smooth impact, " + variant.name + ": order of the force", order, 0.8, 1.3,
                       "first order: contact on nodes moves the wall by 0.17 dx (case elastic_wave)")
          .observed_order = order;
    }
    const Impact& finest = s.impacts.back();
    const double mean = 0.375;  // of sin^4
    if (surface)
      result.check_relative(Label::verification, "smooth impact, contact at the surface, " + variant.name + ": impulse of the wall",
                            finest.impulse, 2.0 * mean, "mV", std::pow(pi * s.cell.back(), 2),
                            "second order: (k dx)² of the wave sin⁴, k = π/L, at the finest grid");
    result.notes.push_back(
        fmt::format("Smooth impact, {}: error of the force {:.2e} to {:.2e}, order {:.2f}; impulse {:.5f} of the exact one; "
                    "energy {:+.1e} of the first at 3 L/c.",
                    variant.name, error.front(), error.back(), order, finest.impulse / (2.0 * mean),
                    finest.energy.back() / finest.energy.front() - 1.0));
    errors.series.push_back({variant.name, s.cell, error, Series::Style::points});
    if (variant.name == "AFLIP, wall on nodes" || !surface)
      history.series.push_back({variant.name, s.impacts.front().time, s.impacts.front().force, Series::Style::simulation});
    kept.insert(kept.end(), s.impacts.begin(), s.impacts.end());
  }
  errors.series.push_back(slope_line("order 2", errors.series.front().x, errors.series.front().y.back(), 2.0));
  errors.series.push_back(slope_line("order 1", errors.series.front().x, errors.series[variants.size() - 1].y.back(), 1.0));
  result.plots.push_back(std::move(errors));
  result.plots.push_back(std::move(history));
  context.log("smooth impact");
}

void uniform_impact(const CaseContext& context, CaseResult& result, const std::vector<int>& grids, std::vector<Impact>& kept) {
  Plot history{"uniform",
               "Bar at one speed: force of the finest grid",
               "time [L/c]",
               "force / ρcVA [-]",
               {{"exact", {0.0, 0.0, 2.0, 2.0, 3.0}, {0.0, 1.0, 1.0, 0.0, 0.0}, Series::Style::reference}},
               "A jump cannot be resolved: fronts are dx^(2/3) wide, and waves shorter than they should be follow or run ahead.",
               false,
               false};
  Plot momentum{"uniform-momentum",
                "Bar at one speed: momentum and energy of the finest grid",
                "time [L/c]",
                "P / mV, E / (mV²/2) [-]",
                {{"exact momentum", {0.0, 2.0, 3.0}, {-1.0, 1.0, 1.0}, Series::Style::reference}},
                "",
                false,
                false};
  std::vector<Variant> variants = surface_variants();
  variants.push_back(nodal_variant());
  for (const Variant& variant : variants) {
    const bool surface = variant.settings.contact == ContactRule::surface;
    const Sweep s = sweep(context, variant.settings, Start::uniform, grids);
    const std::string name = (surface ? "uniform impact, contact at the surface, " : "uniform impact, ") + variant.name;
    std::vector<double> error, loss;
    for (const Impact& r : s.impacts) {
      error.push_back(force_l1(r, Start::uniform));
      loss.push_back(1.0 - r.momentum.back());
    }
    const Impact& finest = s.impacts.back();
    const auto at = [&](double t) { return static_cast<std::size_t>(std::lround(t / (finest.time[1] - finest.time[0]))); };
    double sum = 0.0;
    for (std::size_t i = at(0.5); i < at(1.5); ++i) sum += finest.force[i];
    const double mean = sum / static_cast<double>(at(1.5) - at(0.5));
    result.check_relative(Label::verification, name + ": mean force from 0.5 to 1.5 L/c, over ρcVA", mean, 1.0, "",
                          (surface ? 0.25 : 0.5) * s.cell.back() + 0.01,
                          "a quarter of a cell (contact on nodes: half a cell) over the length, and 1 % for the ringing behind the front");
    const double halfway = 0.5 * (finest.momentum[at(1.0) - 1] + finest.momentum[at(1.0)]);  // velocities live at half steps
    result.check_absolute(Label::verification, name + ": momentum at L/c, where the bar is at rest", halfway, 0.0, "mV",
                          (surface ? 0.25 : 0.5) * s.cell.back(), "a quarter of a cell (contact on nodes: half a cell) over the length");
    const double order = fitted_order(s.cell, error);
    result
        .check_order(Label::verification, name + ": order of the force, mean of |error|", order, 0.55, 1.1,
                     "2/3 for a jump in a scheme of second order (fronts are dx^(2/3) wide), up to 1 where damping outweighs dispersion")
        .observed_order = order;
    result.check_at_most(Label::verification, name + ": loss of speed at the rebound", loss.back(),
                         front_width(s.cell.back(), variant.settings.transfer), "V", 0.0,
                         "the force falls from ρcVA over the width of the front, (6 b (dx/L)²)^(1/3) after 2 L, before the bar lets go");
    double after = 0.0;
    for (std::size_t i = at(2.5); i < finest.force.size(); ++i) after += finest.force[i] * (finest.time[1] - finest.time[0]);
    result.check_at_most(Label::verification, name + ": impulse after 2.5 L/c, when the bar has left", after, 0.0, "mV",
                         front_width(s.cell.back(), variant.settings.transfer),
                         "what rings in the bar may touch once more: a front's share");
    result.notes.push_back(
        fmt::format("{}: mean |error| of the force {:.2e} to {:.2e}, order {:.2f}; mean force {:.4f}; momentum at L/c {:+.4f}; "
                    "rebound at {:.4f} V; impulse after 2.5 L/c {:.1e}; energy {:.4f} at L/c, {:.4f} at 3 L/c.",
                    name, error.front(), error.back(), order, mean, halfway, finest.momentum.back(), after, finest.energy[at(1.0)],
                    finest.energy.back()));
    if (variant.name == "AFLIP, wall on nodes" || !surface) {
      history.series.push_back({variant.name, finest.time, finest.force, Series::Style::simulation});
      momentum.series.push_back({"momentum, " + variant.name, finest.time, finest.momentum, Series::Style::simulation});
      momentum.series.push_back({"energy, " + variant.name, finest.energy_time, finest.energy, Series::Style::simulation});
    }
    kept.insert(kept.end(), s.impacts.begin(), s.impacts.end());
  }
  result.plots.push_back(std::move(history));
  result.plots.push_back(std::move(momentum));
  context.log("impact at one speed");
}

void pulled(const CaseContext& context, CaseResult& result, const std::vector<int>& grids, std::vector<Impact>& kept) {
  std::vector<Variant> variants = surface_variants();
  variants.push_back(nodal_variant());
  for (const Variant& variant : variants) {
    Settings s = variant.settings;
    s.start = Start::pulled;
    s.cells = grids.back();
    const Impact r = hit(context, s);
    const double largest = *std::max_element(r.force.begin(), r.force.end());
    result.check_at_most(Label::verification, "pulled from rest, " + variant.name + ": largest force", largest, 0.0, "ρcVA",
                         std::pow(pi / s.cells, 2),
                         "none passes; the bar's end may swing back by the scheme's second-order error, (π dx/L)²");
    result.check_relative(Label::verification, "pulled from rest, " + variant.name + ": momentum at 3 L/c", r.momentum.back(), 0.375, "mV",
                          std::pow(pi / s.cells, 2), "what it had; at most the impulse of the force above");
    result.notes.push_back(fmt::format("Pulled from rest, {}: largest force {:.1e} ρcVA.", variant.name, largest));
    kept.push_back(r);
  }
}

/// How far before its plane a wall turns a bar that comes flying.
void distance(const CaseContext& context, CaseResult& result) {
  constexpr double speed = 0.01, gap = 4.0;
  constexpr int cells = 32;
  Plot plot{"distance",
            "Where the wall turns a bar that comes flying",
            "wall off the nodes [dx]",
            "distance before the plane [dx]",
            {},
            "",
            false,
            false};
  for (const ContactRule rule : {ContactRule::surface, ContactRule::nodal}) {
    Series line{rule == ContactRule::surface ? "contact at the surface, AFLIP" : "contact on nodes, APIC", {}, {}, Series::Style::points};
    for (const double offset : {0.0, 0.25, 0.5, 0.75}) {
      const Impact r = hit(context, {.start = Start::uniform,
                                     .cells = cells,
                                     .offset = offset,
                                     .contact = rule,
                                     .transfer = rule == ContactRule::surface ? Transfer::aflip : Transfer::apic,
                                     .gap = gap,
                                     .speed = speed,
                                     .duration = gap / cells / speed + 3.0});
      line.x.push_back(offset);
      line.y.push_back((r.turning_point - 0.5 * (1.0 - speed)) * cells);
    }
    const auto [low, high] = std::minmax_element(line.y.begin(), line.y.end());
    // B-splines of the lowest particles, a quarter of a cell above the bar's end, reach 1.5 cells; the wall's first node is on its plane,
    // with contact at the surface up to half a cell before it
    if (rule == ContactRule::surface) {
      result.check_at_most(
          Label::verification, "flying bar, contact at the surface: largest distance before the plane where it turns", *high, 1.75, "dx",
          0.0, "particles reach 1.5 cells, are a quarter of a cell above the end, and meet nodes up to half a cell before the plane");
    }
    result.notes.push_back(
        fmt::format("Not met: a bar that comes flying turns within 0.1 dx of the plane; it is turned {:.2f} to {:.2f} dx before it ({}).",
                    *low, *high, line.name));
    plot.series.push_back(std::move(line));
  }
  result.plots.push_back(std::move(plot));
  context.log("bar that comes flying");
}

void run(const CaseContext& context, CaseResult& result) {
  const auto grids = context.choose<std::vector<int>>({16, 32, 64}, {16, 32, 64, 128}, {16, 32, 64, 128, 256});
  std::vector<Impact> kept;
  smooth_impact(context, result, grids, kept);
  uniform_impact(context, result, grids, kept);
  pulled(context, result, grids, kept);
  std::vector<const Impact*> all;
  for (const Impact& r : kept) all.push_back(&r);
  check_exact_properties(result, all);
  distance(context, result);
}

const Registration registered{{MPM_CASE_NAME, "Elastic bar on a separable wall: impact, release, rebound", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
