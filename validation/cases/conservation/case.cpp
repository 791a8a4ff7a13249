#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/totals.hpp"

namespace mpm::validation {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

MaterialSpec snow(const char* model) {
  MaterialSpec m;
  m.model = model;
  m.density = 300.0;
  m.young_modulus = 1e6;
  m.poisson_ratio = 0.1;
  m.critical_state_slope = 0.8;
  m.cohesion_beta = 0.3;
  m.hardening_xi = 0.5;
  m.preconsolidation_pressure = 1e4;
  return m;
}

/// Two balls of 1 m that meet 0.4 m off centre at 12 m/s.
Case colliding_balls(const char* model) {
  Case c;
  c.title = "two balls";
  c.material = snow(model);
  c.numerics.cell_size = 0.125;
  c.numerics.gravity = 0.0;
  c.bodies.push_back({BodySpec::Shape::sphere, Vec3(-1.2, -0.5, -0.7), Vec3(-0.2, 0.5, 0.3), Vec3(6.0, 0.5, 0.0)});
  c.bodies.push_back({BodySpec::Shape::sphere, Vec3(0.2, -0.5, -0.3), Vec3(1.2, 0.5, 0.7), Vec3(-6.0, 0.0, 0.3)});
  return c;
}

/// Energies over time, and what must not change.
void collide(const CaseContext& context, CaseResult& result, const char* model, const std::string& word) {
  const Case c = colliding_balls(model);
  const Scene scene = make_scene(c);
  State state = make_state(c, scene);
  const Totals start = sum_particles(state, scene);
  const double duration = 0.15;
  Totals now = start;
  double worst_momentum = 0.0, worst_angular = 0.0, highest = 0.0, most_elastic = 0.0;
  Series kinetic{word + ", kinetic", {}, {}, Series::Style::simulation}, elastic{word + ", elastic", {}, {}, Series::Style::simulation},
      total{word + ", sum", {}, {}, Series::Style::simulation};
  const double scale_l = start.angular_momentum_scale;
  while (state.time < duration) {
    step(state, scene, std::min(stable_time_step(state, scene), duration - state.time));
    now = sum_particles(state, scene);
    worst_momentum = std::max(worst_momentum, (now.momentum - start.momentum).norm() / start.momentum_scale);
    worst_angular = std::max(worst_angular, (now.angular_momentum - start.angular_momentum).norm() / scale_l);
    highest = std::max(highest, now.kinetic_energy + now.elastic_energy);
    most_elastic = std::max(most_elastic, now.elastic_energy);
    kinetic.x.push_back(1e3 * state.time);
    kinetic.y.push_back(now.kinetic_energy);
    elastic.y.push_back(now.elastic_energy);
    total.y.push_back(now.kinetic_energy + now.elastic_energy);
  }
  elastic.x = total.x = kinetic.x;
  const double round_off = static_cast<double>(state.step) * epsilon;
  const double energy = start.kinetic_energy + start.elastic_energy;
  result.check_absolute(Label::verification, word + " balls: particles lost or gained", static_cast<double>(now.count),
                        static_cast<double>(start.count), "", 0.0, "mass lives on particles");
  result.check_relative(Label::verification, word + " balls: mass", now.mass, start.mass, "kg", static_cast<double>(start.count) * epsilon,
                        "the same numbers summed in another order");
  result.check_absolute(Label::verification, word + " balls: largest change of linear momentum over sum m|v|", worst_momentum, 0.0, "",
                        round_off, "one rounding a step, all in one direction");
  result.check_absolute(Label::verification, word + " balls: largest change of angular momentum over sum m|x||v|", worst_angular, 0.0, "",
                        round_off, "one rounding a step, all in one direction");
  result.check_at_most(Label::verification, word + " balls: energy after the collision over that before",
                       (now.kinetic_energy + now.elastic_energy) / energy, 1.0, "", 0.0, "nothing creates energy");
  result.check_at_most(Label::verification, word + " balls: largest energy on the way over that before", highest / energy, 1.0, "",
                       0.5 * scene.cfl * most_elastic / energy,
                       "symplectic Euler exchanges up to CFL/2 of the elastic energy with its shadow energy");
  result.notes.push_back(fmt::format("{} balls: {} particles, {} steps, {:.1f} % of the energy left after {} s.", word, start.count,
                                     state.step, 100.0 * (now.kinetic_energy + now.elastic_energy) / energy, duration));
  result.plots.push_back({word + "-energy",
                          "Energy in the collision, " + word + " balls",
                          "time [ms]",
                          "energy [J]",
                          {{"at the start", {0.0, 1e3 * duration}, {energy, energy}, Series::Style::bound}, kinetic, elastic, total},
                          "",
                          false,
                          false});
  context.log(fmt::format("{} balls done", word));
}

/// A block of snow dropped obliquely on a frictional floor that moves: who took how much momentum?
void drop(CaseResult& result) {
  Case c;
  c.title = "dropped block";
  c.material = snow("cohesive_cam_clay");
  c.numerics.cell_size = 0.125;
  c.numerics.gravity = 9.81;
  c.bodies.push_back({BodySpec::Shape::box, Vec3(-0.5, -0.5, 0.05), Vec3(0.5, 0.5, 1.05), Vec3(2.0, 0.0, -3.0)});
  WallSpec floor;
  floor.contact = Contact::separable;
  floor.friction = 0.4;
  floor.velocity = Vec3(0.0, 1.0, 0.0);
  c.walls.push_back(floor);
  const Scene scene = make_scene(c);
  State state = make_state(c, scene);
  Totals before = sum_particles(state, scene);
  const double scale = before.momentum_scale;
  double worst = 0.0;
  Vec3 taken = Vec3::Zero();
  for (int i = 0; i < 300; ++i) {
    const StepReport report = step(state, scene, stable_time_step(state, scene));
    const Totals after = sum_particles(state, scene);
    const Vec3 gravity = after.mass * report.dt * scene.gravity;
    worst = std::max(worst, (after.momentum - before.momentum - gravity + report.impulses.at(0).linear).norm() / scale);
    taken += report.impulses.at(0).linear;
    before = after;
  }
  result.check_absolute(Label::verification, "dropped block: largest gap in the momentum balance of a step over sum m|v|", worst, 0.0, "",
                        1e-12, "sums over thousands of nodes and particles in another order");
  result.check_at_most(Label::verification, "dropped block: friction over mu times normal impulse", taken.head<2>().norm() / -taken.z(),
                       0.4, "", 1e-9, "Coulomb's bound holds at every node, so for the sum; 1e-9 for round-off");
}

void run(const CaseContext& context, CaseResult& result) {
  collide(context, result, "hencky_elastic", "elastic");
  collide(context, result, "cohesive_cam_clay", "snow");
  drop(result);
}

const Registration registered{{MPM_CASE_NAME, "Conservation of mass, momentum and angular momentum", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
