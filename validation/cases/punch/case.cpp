#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/core/diagnostics.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/setup.hpp"
#include "validation/harness/slender.hpp"

namespace mpm::validation::punch {
namespace {

constexpr double pi = std::numbers::pi;

/// Prandtl's limit load over the cohesion: N_c = (N_q - 1) cot phi, N_q = exp(pi tan phi) tan^2(pi/4 + phi/2); 2 + pi without friction.
double limit_load(double friction_angle) {
  if (friction_angle < 1e-3) return 2.0 + pi;
  const double t = std::tan(0.25 * pi + 0.5 * friction_angle);
  return (std::exp(pi * std::tan(friction_angle)) * t * t - 1.0) / std::tan(friction_angle);
}

struct Settings {
  std::string name;
  int cells = 8;  ///< in the width of the punch
  ContactRule contact = ContactRule::surface;
  Transfer transfer = Transfer::aflip;
  double friction = 0.0;  ///< of the punch
};

struct Load {
  double cell = 0.0;                      ///< over the width
  std::vector<double> penetration, load;  ///< over the width; over c times the width
  double limit = 0.0;                     ///< mean load over the last quarter
  double rise = 0.0;                      ///< over that quarter
  double particle_steps = 0.0;
};

constexpr double deepest = 0.02;  ///< penetration at the end, over the width

constexpr int samples = 120;  ///< of the load

/// The punch moves into the snow, which is at rest far away: in the frame of the punch the snow comes.
Setup punch_setup(const Case& base, const Settings& s) {
  Case c = base;
  const double dx = c.obstacle->width() / s.cells;
  c.numerics.cell_size = dx;
  c.numerics.contact = s.contact;
  c.numerics.transfer = s.transfer;
  c.obstacle->friction = s.friction;
  set_side(c, 0.5 * dx, {2});
  const double duration = deepest * c.obstacle->width() / c.bodies[0].velocity.x();
  return {.id = fmt::format("{}-cells{}", s.friction > 0.0 ? "rough" : "smooth", s.cells),
          .title = fmt::format("{}, {} cells in its width", s.name, s.cells),
          .spec = std::move(c),
          .times = even_times(0.0, duration, samples),
          .particles = false,
          .forces = true};
}

Load press(const CaseContext& context, const Settings& s) {
  const Setup setup = punch_setup(context.read_case(), s);
  const Case& c = setup.spec;
  const double width = c.obstacle->width(), v = c.bodies[0].velocity.x();
  const double unit = c.material.as<DruckerPrager>().cohesion * width * 0.5 * c.numerics.cell_size;
  Load r;
  r.cell = 1.0 / s.cells;
  r.particle_steps = play(context, setup, [&](const Instant& now) {
                       r.penetration.push_back(0.5 * (now.before + now.time) * v / width);
                       r.load.push_back(whole_force(now.forces.back(), {false, true}).x() / unit);
                       return true;
                     }).particle_steps;
  const auto mean = [&](int from, int to) {
    double sum = 0.0;
    for (int i = from; i < to; ++i) sum += r.load[static_cast<std::size_t>(i)];
    return sum / (to - from);
  };
  r.limit = mean(3 * samples / 4, samples);
  r.rise = mean(7 * samples / 8, samples) / mean(3 * samples / 4, 7 * samples / 8) - 1.0;
  return r;
}

std::vector<int> grids_of(const CaseContext& context) {
  return context.choose<std::vector<int>>({6, 8}, {6, 8, 12, 16, 24}, {6, 8, 12, 16, 24, 32, 48});
}

/// The runs that every solver makes: the smooth punch on all grids, then the rough one.
std::vector<Settings> settings_of(const CaseContext& context) {
  const std::vector<int> grids = grids_of(context);
  std::vector<Settings> all;
  for (const int cells : grids) all.push_back({"smooth punch", cells});
  all.push_back({"rough punch", grids[1], ContactRule::surface, Transfer::aflip, 1.0});
  return all;
}

std::vector<Setup> setups(const CaseContext& context) {
  const Case base = context.read_case();
  std::vector<Setup> all;
  for (const Settings& s : settings_of(context)) all.push_back(punch_setup(base, s));
  return all;
}

void run(const CaseContext& context, CaseResult& result) {
  const double exact = limit_load(0.0);
  result.check_relative(Label::verification, "reference: Prandtl's N_c at a friction angle of 20° over the tables' 14.83",
                        limit_load(pi / 9.0), 14.83, "", 5e-4, "two digits are given (Terzaghi's and all later tables of N_c)");
  const auto grids = grids_of(context);
  std::vector<Settings> all = settings_of(context);
  const std::size_t smooth = grids.size();
  if (own_run(context) && context.level() != Level::quick)
    all.push_back({"contact on nodes, APIC", grids.back(), ContactRule::nodal, Transfer::apic});
  std::vector<Load> loads(all.size());
  play_in_parallel(context, all.size(), [&](std::size_t i) {
    const std::size_t k = all.size() - 1 - i;  // the longest first
    loads[k] = press(context, all[k]);
  });

  std::vector<double> cell, limit;
  Plot curves{"load", "Load on the punch", "penetration / width [-]", "force / (c · width) [-]"};
  curves.series.push_back({"2 + π", {0.0, deepest}, {exact, exact}, Series::Style::reference});
  double work = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    work += loads[i].particle_steps;
    const std::string name = fmt::format("{}, {} cells", all[i].name, all[i].cells);
    if (i < smooth) {
      cell.push_back(loads[i].cell);
      limit.push_back(loads[i].limit);
    }
    curves.series.push_back({name, loads[i].penetration, loads[i].load, Series::Style::simulation});
    result.notes.push_back(fmt::format("{}: limit load {:.3f} c, {:.3f} of Prandtl's; it rises by {:.1e} over the last eighth.", name,
                                       loads[i].limit, loads[i].limit / exact, loads[i].rise));
  }
  result.plots.push_back(std::move(curves));
  for (std::size_t i = 0; i < smooth; ++i) {
    const std::string name = fmt::format("smooth punch, {} cells: limit load over c", grids[i]);
    Check& load = result
                      .check_relative(Label::verification, name, limit[i], exact, "", 0.5 * cell[i] + 0.02,
                                      "first order: the face is known to half a cell, dx/(2w); 2 % for the waves of the push and the "
                                      "penetration, whose effect on the load is known to be some per cent")
                      .in_summary(Quantity::force, 0.0, 350.0);
    if (grids[i] == 12 || grids[i] == 16)
      load.known_miss(1.07 * exact,
                      "penetration of 2 % of the width and locking of isochoric flow; the load still falls with the cell size");
    result.check_at_most(Label::verification, name + ", from above: Prandtl's load over it", exact / limit[i], 1.0, "", 0.0,
                         "an upper bound: a velocity field on a grid is one of those over which the limit load is the least");
    if (i > 0)
      result.check_at_most(Label::verification, name + ", over that with fewer cells", limit[i] / limit[i - 1], 1.0, "", 0.005,
                           "a finer grid has more velocity fields; half a per cent for the ringing of the load");
  }
  result.check_at_most(Label::verification, fmt::format("smooth punch, {} cells: rise of the load over the last eighth", grids.back()),
                       std::abs(loads[smooth - 1].rise), 0.0, "", 0.01, "a limit load is one: it stays, but for the penetration of 0.25 %");
  result.check_relative(Label::verification, fmt::format("rough punch over smooth punch, {} cells", grids[1]),
                        loads[smooth].limit / limit[1], 1.0, "", 0.5 * cell[1] + 0.02,
                        "Prandtl's load is the same for a rough and a smooth punch; the tolerance is that of the smooth one");
  result.plots.push_back({"grids",
                          "Limit load over the cell size",
                          "dx / width [-]",
                          "limit load / c [-]",
                          {{"2 + π", {0.0, cell.front()}, {exact, exact}, Series::Style::reference},
                           {"smooth punch", cell, limit, Series::Style::points},
                           {"rough punch", {loads[smooth].cell}, {loads[smooth].limit}, Series::Style::points}}});
  result.notes.push_back(fmt::format("{:.1f} million particle-steps.", 1e-6 * work));
}

const Registration registered{{.title = "Prandtl's punch: limit load on an obstacle", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::punch
