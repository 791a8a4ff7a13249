#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"

namespace mpm::validation {
namespace {

/// What one block did, step by step.
struct Slide {
  std::vector<double> time{0.0}, distance{0.0};  ///< s, m; of the centre of mass, along the floor
  std::vector<double> speed{0.0};                ///< m/s, mean along the floor
  double rise = 0.0;                             ///< m; of the centre of mass, while the block slides
  double friction_error = 0.0;                   ///< largest |J_x / (mu J_z) - 1| of a step while all of the block slides
  double largest_step = 0.0;                     ///< s
};

/// Lets the block of `c` slide for its duration.
/// @param rest_time  s, when it should come to rest; friction is fully mobilised well before
Slide slide(const Case& c, double rest_time, State& state, const Scene& scene) {
  const double mu = c.walls.front().friction;
  Slide s;
  const Totals start = totals(state, scene);
  s.speed[0] = start.momentum.x() / start.mass;
  double path = 0.0;
  advance(state, scene, c.output.duration, [&](const StepReport& step) {
    const Totals now = totals(state, scene);
    const double v = now.momentum.x() / now.mass;
    if (state.time <= rest_time) s.rise += step.dt * now.momentum.z() / now.mass;
    path += step.dt * v;  // APIC moves each particle with the grid's velocity, whose mass-weighted mean is that of the particles
    s.time.push_back(state.time);
    s.distance.push_back(path);
    s.speed.push_back(v);
    s.largest_step = std::max(s.largest_step, step.dt);
    const Vec3& impulse = step.impulses.front().linear;
    if (state.time < 0.9 * rest_time && impulse.z() < 0.0)
      s.friction_error = std::max(s.friction_error, std::abs(impulse.x() / (-mu * impulse.z()) - 1.0));
  });
  return s;
}

void run(const CaseContext& context, CaseResult& result) {
  Case c = read_case(context.case_directory() / "case.toml");
  c.numerics.cell_size = context.choose(0.125, 0.0625, 0.0625);
  const double mu = c.walls.front().friction, g = c.numerics.gravity, v0 = c.bodies.front().velocity.x(), height = 0.5;
  // Bound of what the block sinks under its weight, the first bounce included.
  const double sinking = c.material.density() * g * height * height / c.material.as<HenckyElastic>().young_modulus;
  const double shear_speed = std::sqrt(0.5 * c.material.as<HenckyElastic>().young_modulus /
                                       (1.0 + c.material.as<HenckyElastic>().poisson_ratio) / c.material.density());

  const double stop_time = v0 / (mu * g), stop_distance = 0.5 * v0 * stop_time;
  Scene scene = make_scene(c);
  State state = make_state(c, scene);
  const Slide thrown = slide(c, stop_time, state, scene);
  result.check_relative(Label::verification, "thrown: distance to rest, + μ times the rise of the block",
                        thrown.distance.back() + mu * thrown.rise, stop_distance, "m", v0 * thrown.largest_step / stop_distance,
                        "one step of motion (symplectic Euler)");
  result.check_at_most(Label::verification, "thrown: friction over μ times normal force in a step, largest deviation from 1",
                       thrown.friction_error, std::pow(0.5 * height * std::sqrt(sinking / height * g / height) / (0.1 * v0), 2) + 1e-9, "",
                       0.0, "nodes slip sideways by the block's own vibration: second order in its angle; round-off of sums");
  result.check_absolute(Label::verification, "thrown: speed at the end", thrown.speed.back(), 0.0, "m/s", mu * g * height / shear_speed,
                        "the shear that friction had built up is released, and nothing damps it: Δτ = ρ c_S Δv");
  result.flows.push_back(flow_picture(context.directory(), state, scene,
                                      {.id = "rest",
                                       .field = FlowField::pressure,
                                       .title = "Block at rest",
                                       .caption = "The stop left it vibrating: nothing damps it.",
                                       .slice_half_width = 0.0}));

  Series exact{"v₀t - μgt²/2", {}, {}, Series::Style::reference}, ours{"simulation", {}, {}, Series::Style::simulation};
  for (int i = 0; i <= 70; ++i) {
    const double t = std::min(0.01 * i, stop_time);
    exact.x.push_back(0.01 * i);
    exact.y.push_back(v0 * t - 0.5 * mu * g * t * t);
  }
  for (std::size_t i = 0; i < thrown.time.size(); i += 20) {
    ours.x.push_back(thrown.time[i]);
    ours.y.push_back(thrown.distance[i]);
  }
  result.plots.push_back({.id = "distance",
                          .title = "Block thrown along a floor",
                          .x_label = "time [s]",
                          .y_label = "distance [m]",
                          .series = {exact, ours},
                          .caption = fmt::format("μ = {}, v₀ = {} m/s.", mu, v0)});

  const double duration = 0.4;
  struct Slope {
    double degrees, speed;
    const char* what;
  };
  for (const Slope slope : {Slope{30.0, 1.0, "thrown down a slope of 30°"}, Slope{10.0, 0.0, "left on a slope of 10°"}}) {
    const double angle = slope.degrees * std::numbers::pi / 180.0;
    Case inclined = c;
    inclined.bodies.front().velocity = Vec3(slope.speed, 0.0, 0.0);
    inclined.numerics.slope = angle;
    inclined.output.duration = duration;
    scene = make_scene(inclined);
    state = make_state(inclined, scene);
    const Slide s = slide(inclined, duration, state, scene);
    if (mu < std::tan(angle)) {
      const double acceleration = g * (std::sin(angle) - mu * std::cos(angle));
      result.check_absolute(Label::verification, fmt::format("{}: distance after {} s, + μ times the rise", slope.what, duration),
                            s.distance.back() + mu * s.rise, slope.speed * duration + 0.5 * acceleration * duration * duration, "m",
                            acceleration * duration * s.largest_step, "one step of motion (symplectic Euler)");
    } else {
      result.check_absolute(Label::verification, fmt::format("{}, where it holds: distance after {} s", slope.what, duration),
                            s.distance.back(), 0.0, "m", 2.0 * (1.0 + mu) * sinking,
                            "sinking and shearing under its own weight, doubled by the first bounce");
    }
  }
  result.notes.push_back(
      fmt::format("dx = {} m, {} particles, steps of {:.2g} s. While it slid the thrown block rose by {:.2g} mm, {:.2g} % of a cell: "
                  "contact holds back what "
                  "moves towards the floor, but pulls nothing back that has hopped. Its path became {:.2g} mm longer than v₀²/(2 μ g) by "
                  "this and by the time step.",
                  c.numerics.cell_size, state.grid.particle_count(), thrown.largest_step, 1e3 * thrown.rise,
                  100.0 * thrown.rise / c.numerics.cell_size, 1e3 * (thrown.distance.back() - stop_distance)));
}

const Registration registered{{MPM_CASE_NAME, "Sliding block with Coulomb friction", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
