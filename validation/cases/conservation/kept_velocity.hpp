#pragma once
/// The part of the particles' velocities that the grid cannot carry, and how long AFLIP keeps it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/periodic.hpp"

namespace mpm::validation {

/// A periodic cube of 4 cells of an elastic body. Its velocities along x change sign from one layer of particles to the next along y. The
/// lattice has two particles a cell and axis, at quarters of the cell, so that every node receives as much from the one sign as from the
/// other: the grid is at rest, no particle moves, and nothing acts but the rule for what is kept.
/// @returns {mean of the velocities over their initial values, largest departure of one of them from this mean} at t = t_ref
inline std::pair<double, double> kept_velocity(double cfl, double relaxation_cells, double relaxation_time, double speed) {
  Case c;
  c.title = "velocities that the grid cannot carry";
  c.material = HenckyElastic::Parameters{};
  c.material.set_density(300.0);
  c.material.as<HenckyElastic>().young_modulus = 1e6;
  c.material.as<HenckyElastic>().poisson_ratio = 0.0;
  c.numerics.cell_size = 0.25;
  c.numerics.gravity = 0.0;
  c.numerics.transfer = Transfer::aflip;
  c.numerics.relaxation_cells = relaxation_cells;
  c.numerics.cfl = cfl;
  c.bodies.push_back({BodySpec::Shape::box, Vec3::Zero(), Vec3::Ones(), Vec3::Zero(), Lattice::aligned});
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const auto sign = [&](const Particle& p) {
    return std::lround(std::floor(2.0 * p.position[1] / c.numerics.cell_size)) % 2 == 0 ? 1.0 : -1.0;
  };
  state.grid.change_particles([&](Particle& p) { p.velocity[0] = speed * sign(p); });
  state.max_speed = speed;
  const PeriodicBox box(scene.offset, Vec3::Ones(), 2.5 * c.numerics.cell_size, state.next_id);
  const auto steps = static_cast<int>(std::ceil(relaxation_time / stable_time_step(state, scene)));
  for (int i = 0; i < steps; ++i) {
    box.renew(state);
    step(state, scene, relaxation_time / steps);
  }
  double sum = 0.0, count = 0.0, low = 1e300, high = -1e300;
  state.grid.for_each_particle([&](const Particle& p) {
    if (!box.owns(p)) return;
    const double kept = p.velocity[0] * sign(p) / speed;
    sum += kept, count += 1.0;
    low = smaller(low, kept), high = larger(high, kept);
  });
  return {sum / count, std::max(high - sum / count, sum / count - low)};
}

/// It decays as exp(-t/t_ref), t_ref = K dx/(c + v) with K = relaxation_cells; the step's rule 1 - dt/t_ref is of first order.
inline void check_kept_velocity(CaseResult& result) {
  constexpr double cells = 5.0, cell_size = 0.25, speed = 1e-6;
  const double relaxation_time = cells * cell_size / (std::sqrt(1e6 / 300.0) + speed);
  double error[2];
  for (const int i : {0, 1}) {
    const double cfl = i == 0 ? 0.4 : 0.2;
    const auto [kept, departure] = kept_velocity(cfl, cells, relaxation_time, speed);
    const double h = cfl / cells;
    error[i] = 1.0 - kept * std::numbers::e;
    const std::string what = fmt::format("velocities that the grid cannot carry, AFLIP, CFL {}: ", cfl);
    result.check_relative(Label::verification, what + "share left after the time K dx/(c + v), over 1/e", kept * std::numbers::e, 1.0, "",
                          0.5 * h + h * h, "ln(1 - h) = -h - h²/2 - ..., with the step h = CFL/K over that time: h/2, and the next term");
    result.check_at_most(Label::verification, what + "departure of a particle from the mean", departure, 0.0, "", 1e-10,
                         "the grid is at rest, all particles obey one rule; round-off");
  }
  const double order = std::log2(error[0] / error[1]);
  result
      .check_order(Label::verification, "velocities that the grid cannot carry: order in dt of the share left", order, 0.9, 1.1,
                   "h/2 + O(h²): the next term is a few per cent of the first")
      .observed_order = order;
}

}  // namespace mpm::validation
