#pragma once
/// An elastic bar that meets a wall or is pulled off it: one run, and what happened in it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/setup.hpp"
#include "validation/harness/slender.hpp"

namespace mpm::validation::bar {

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
  double full = 0.0;                ///< rho c V A, N
  double speed = 0.0;               ///< V, m/s
  std::vector<double> time, force;  ///< of each step
  std::vector<double> momentum;     ///< after each step, away from the wall
  std::vector<double> energy_time, energy;
  double impulse = 0.0;        ///< that the wall gave in all
  double largest_pull = 0.0;   ///< largest force of a step towards the wall
  double balance = 0.0;        ///< largest difference between a step's change of momentum and the wall's impulse
  double turning_point = 0.0;  ///< of the centre of mass, over L: where it is nearest to the wall
};

inline double shape(Start start, double x) { return start == Start::uniform ? 1.0 : std::pow(std::sin(0.5 * pi * x), 4); }
inline double shape_slope(Start start, double x) {
  return start == Start::uniform ? 0.0 : 2.0 * pi * std::pow(std::sin(0.5 * pi * x), 3) * std::cos(0.5 * pi * x);
}
/// The force of the exact solution over rho c V A, t in L/c: d'Alembert, derived in the README.
inline double exact_force(Start start, double t) {
  if (start == Start::pulled || t <= 0.0 || t >= 2.0) return 0.0;
  return shape(start, t);  // sin^4 is even about x = L
}

inline const char* name_of(Start start) {
  switch (start) {
    case Start::uniform: return "uniform";
    case Start::smooth: return "smooth";
    case Start::pulled: return "pulled";
  }
  return "";
}

/// One run: results after every step, because the force and the momentum of each are judged.
inline Setup bar_setup(const Case& base, const Settings& s) {
  Case c = base;
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
  const double speed = wave_speed_of(make_scene(c).material), dt = length / speed / std::ceil(s.cells / c.numerics.cfl);
  const auto steps = static_cast<std::size_t>(std::lround(s.duration * length / speed / dt));
  return {.id = fmt::format("{}-cells{}{}", name_of(s.start), s.cells, s.gap > 0.0 ? "-flying" : ""),
          .title = fmt::format("{} start, {} cells in the bar's length{}", name_of(s.start), s.cells,
                               s.gap > 0.0 ? ", from a distance of some cells" : ""),
          .spec = std::move(c),
          .start =
              [s, length, speed](const Case& spec, const Scene& scene) {
                State state = make_state(spec, scene);
                const double v = s.speed * speed * (s.start == Start::pulled ? 1.0 : -1.0);
                state.grid.change_particles([&](Particle& p) {
                  const double x = (p.position[0] - scene.offset.x()) / length - s.gap / s.cells;
                  p.velocity[0] = v * shape(s.start, x);
                  p.affine[0] = v * shape_slope(s.start, x) / length;
                });
                return state;
              },
          .times = even_times(0.0, static_cast<double>(steps) * dt, steps),
          .fields = {.position = false},
          .forces = true,
          .time_step = dt};
}

inline Impact hit(const CaseContext& context, const Settings& s) {
  const Setup setup = bar_setup(context.read_case(), s);
  const Case& c = setup.spec;
  const CaseScene scene = make_scene(c);
  const double length = c.bodies[0].max.x() - c.bodies[0].min.x(), side = c.bodies[0].max.y(), dt = setup.time_step;
  const double speed = wave_speed_of(scene.material), v = s.speed * speed, density = density_of(scene.material);
  const double unit = length / speed, mass = density * length * side * side, full = density * speed * v * side * side;
  const State start = setup.start(c, scene);
  Impact r;
  r.cell = 1.0 / s.cells;
  r.full = full;
  r.speed = v;
  double elastic = 0.0, kinetic = -1.0, before = totals(start, scene).momentum.x();
  double centre = (0.5 * length + c.bodies[0].min.x()) / length;
  r.turning_point = centre;
  play(context, setup, [&](const Instant& now) {
    const double begin = static_cast<double>(now.index) * dt / unit;    // stresses of the step's start act in it
    const double given = -now.forces[0].x() * (now.time - now.before);  // to the bar, away from the wall
    double momentum = 0.0;
    for (const ParticleRecord& p : now.particles) momentum += p.mass * p.velocity.x();
    r.time.push_back(begin);
    r.force.push_back(given / (dt * full));
    r.momentum.push_back(momentum / (mass * v));
    r.impulse += given / (mass * v);
    r.largest_pull = larger(r.largest_pull, -given / (dt * full));
    r.balance = larger(r.balance, std::abs(momentum - before - given) / (mass * v));
    before = momentum;
    centre += dt * before / (mass * length);
    r.turning_point = smaller(r.turning_point, centre);
    if (now.state == nullptr) return true;
    // velocities live at half steps: their energies before and after a stress are averaged
    const Totals all = totals(*now.state, *now.scene);
    const double moving = all.kinetic_energy + all.affine_energy;
    if (kinetic >= 0.0) {
      r.energy_time.push_back(begin);
      r.energy.push_back((elastic + 0.5 * (kinetic + moving)) / (0.5 * mass * v * v));
    }
    kinetic = moving;
    elastic = all.elastic_energy;
    return true;
  });
  return r;
}

}  // namespace mpm::validation::bar
