#include "mpm/health.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mpm/error.hpp"

namespace mpm {

namespace {

constexpr double short_step = 0.1;  ///< of the first: the fastest particle moves at nine times the speed of sound and of the start

double energy_of(const Totals& t) { return t.kinetic_energy + t.affine_energy + t.elastic_energy; }

Vec3 position_of(const Particle& p) { return {p.position[0], p.position[1], p.position[2]}; }

/// "particle 7 at (1, 2, 3) m", in the coordinates of the case
std::string place_of(const Particle& p, const Scene& scene) {
  const Vec3 x = position_of(p) - scene.offset;
  return fmt::format("particle {} at ({:.4g}, {:.4g}, {:.4g}) m", p.id, x.x(), x.y(), x.z());
}

Particle fastest_particle(const State& state) {
  Particle fastest{};
  double most = -1.0;
  state.grid.for_each_particle([&](const Particle& p) {
    const double speed = Eigen::Map<const Vec3>(p.velocity).squaredNorm();
    if (speed > most || (speed == most && p.id < fastest.id)) most = speed, fastest = p;
  });
  return fastest;
}

/// Does the boundary dictate the velocity of all eight nodes of the cell that holds x?
template <class B>
bool holds_cell_of(const B& boundary, const Vec3& x, double cell_size, double time) {
  const Vec3 low = cell_size * (x / cell_size).array().floor().matrix();
  for (int n = 0; n < 8; ++n) {
    if (!boundary.covers(low + cell_size * Vec3(n & 1, n >> 1 & 1, n >> 2), time)) return false;
  }
  return true;
}

}  // namespace

EnergyWatch::EnergyWatch(const State& state, const Scene& scene) : gravity_(scene.gravity) {
  const Totals t = totals(state, scene);
  momentum_ = t.momentum;
  start_ = largest_ = energy_of(t);
}

void EnergyWatch::book(const StepReport& report) {
  momentum_ += report.entered.momentum + report.gravity_impulse;
  for (const Impulse& taken : report.impulses) {
    momentum_ -= taken.linear;
    given_ += taken.work;
  }
  given_ += report.dt * gravity_.dot(momentum_) + report.entered.energy - report.left.energy;
  momentum_ -= report.left.momentum;
}

double EnergyWatch::excess_share(const Totals& now) {
  momentum_ = now.momentum;  // drops the round-off of the steps since
  const double energy = energy_of(now);
  largest_ = std::max(largest_, energy);
  gain_ = energy - start_ - given_;
  lowest_ = std::min(lowest_, gain_);
  excess_ = gain_ - lowest_;
  return largest_ > 0.0 ? excess_ / largest_ : 0.0;
}

HealthWatch::HealthWatch(const State& state, const Scene& scene) : energy_(state, scene), first_step_(stable_time_step(state, scene)) {}

std::vector<std::string> HealthWatch::check(const State& state, const Scene& scene, const Totals& now) {
  std::vector<std::string> warnings;
  const double share = energy_.excess_share(now);
  const bool unstable = share > EnergyWatch::beyond_doubt;
  if (unstable || (share > EnergyWatch::suspicious && !told_energy_)) {
    const std::string text = fmt::format(
        "at t = {:.6g} s, step {}: {:.3g} J, {:.0f} % of the largest energy so far, came from nothing (neither gravity, nor walls, nor the "
        "inlet gave it); the fastest is {}, {:.4g} m/s. Try a smaller [numerics] cfl or a finer cell_size_m",
        state.time, state.step, energy_.excess(), 100.0 * share, place_of(fastest_particle(state), scene), state.max_speed);
    if (unstable) throw UnstableError("unstable " + text);
    warnings.push_back("warning: the run may be unstable " + text);
    told_energy_ = true;
  }
  const double dt = stable_time_step(state, scene);
  if (dt < short_step * first_step_ && !told_step_) {
    warnings.push_back(fmt::format(
        "warning: the time step has shrunk to {:.3g} s at t = {:.6g} s, step {}, from {:.3g} s at the start: {} moves at {:.4g} m/s. If "
        "nothing should be that fast, try a smaller [numerics] cfl or a finer cell_size_m",
        dt, state.time, state.step, first_step_, place_of(fastest_particle(state), scene), state.max_speed));
    told_step_ = true;
  }
  return warnings;
}

std::vector<std::string> particles_inside_boundaries(const State& state, const Scene& scene) {
  std::vector<std::string> warnings;
  for (std::size_t b = 0; b < scene.boundaries.size(); ++b) {
    if (scene.feed && b != scene.obstacle) continue;
    std::size_t count = 0;
    Particle first{};
    std::visit(
        [&](const auto& boundary) {
          state.grid.for_each_particle([&](const Particle& p) {
            if (!holds_cell_of(boundary, position_of(p), state.grid.cell_size(), state.time)) return;
            if (count == 0 || p.id < first.id) first = p;
            ++count;
          });
        },
        scene.boundaries[b]);
    if (count == 0) continue;
    const std::string which = b == scene.obstacle ? "the [obstacle]" : fmt::format("[[wall]] number {}", b + 1);
    warnings.push_back(
        fmt::format("warning: {} particles are inside {}, which holds them, {} for one; move the [[body]] out of it, or the boundary",
                    count, which, place_of(first, scene)));
  }
  return warnings;
}

}  // namespace mpm
