#include "libmpm/core/health.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/core/step.hpp"

namespace mpm {

namespace {

constexpr double short_step = 0.1;  ///< of the first: the fastest particle moves at nine times the speed of sound and of the start

double energy_of(const Totals& t) { return t.kinetic_energy + t.affine_energy + t.elastic_energy; }

/// "particle 7 at (1, 2, 3) m", in the coordinates of the case
std::string position_text(const Particle& p, const Scene& scene) {
  return "particle " + std::to_string(p.id) + " at " + vector_text(position_of(p) - scene.offset) + " m";
}

/// Whether the boundary covers all eight corners of the cube between nodes that holds x.
template <class B>
bool covers_cube_around(const B& boundary, const Vec3& x, double cell_size, double time) {
  const Vec3 low = cell_size * (x / cell_size).array().floor().matrix();
  for (int n = 0; n < 8; ++n) {
    if (!boundary.covers(low + cell_size * Vec3(n & 1, n >> 1 & 1, n >> 2), time)) return false;
  }
  return true;
}

}  // namespace

Particle fastest_particle(const State& state) {
  Particle fastest{};
  double most = -1.0;
  const auto compare = [&](const Particle& p) {
    const double speed = Eigen::Map<const Vec3>(p.velocity).squaredNorm();
    if (speed > most || (speed == most && p.id < fastest.id)) most = speed, fastest = p;
  };
  Ranks& ranks = state.grid.ranks();
  ranks.instruct(CoreTask::fastest, state);
  state.grid.for_each_particle(compare);
  Message mine;
  if (most >= 0.0) put(mine, fastest);
  for (const Message& message : ranks.gather(std::move(mine))) {
    if (!message.empty()) compare(MessageReader(message).get<Particle>());
  }
  ranks.done();
  return fastest;
}

EnergyWatch::EnergyWatch(const State& state, const Scene& scene) : gravity_(scene.gravity) {
  const Totals t = totals(state, scene);
  momentum_ = t.momentum;
  start_ = largest_ = energy_of(t);
}

void EnergyWatch::add(const StepReport& report) {
  momentum_ += report.entered.momentum + report.gravity_impulse;
  for (const Impulse& taken : report.impulses) {
    momentum_ -= taken.linear;
    given_ += taken.work;
  }
  given_ += report.dt * gravity_.dot(momentum_) + report.entered.energy - report.left.energy;
  momentum_ -= report.left.momentum;
}

double EnergyWatch::excess_ratio(const Totals& now) {
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
  const double excess = energy_.excess_ratio(now);
  const bool unstable = excess > EnergyWatch::beyond_doubt;
  if (unstable || (excess > EnergyWatch::suspicious && !warned_energy_)) {
    const std::string text = "at t = " + number_text(state.time) + " s, step " + std::to_string(state.step) + ": " +
                             number_text(energy_.excess(), 3) + " J, " + std::to_string(std::lround(100.0 * excess)) +
                             " % of the largest energy so far, came from nothing (neither gravity, nor walls, nor the inlet gave it); the "
                             "fastest is " +
                             position_text(fastest_particle(state), scene) + ", " + number_text(state.max_speed, 4) +
                             " m/s. Try a smaller CFL number or a finer grid";
    if (unstable) throw UnstableError("unstable " + text);
    warnings.push_back("warning: the run may be unstable " + text);
    warned_energy_ = true;
  }
  const double dt = stable_time_step(state, scene);
  if (dt < short_step * first_step_ && !warned_step_) {
    warnings.push_back("warning: the time step has shrunk to " + number_text(dt, 3) + " s at t = " + number_text(state.time) + " s, step " +
                       std::to_string(state.step) + ", from " + number_text(first_step_, 3) +
                       " s at the start: " + position_text(fastest_particle(state), scene) + " moves at " +
                       number_text(state.max_speed, 4) + " m/s. If nothing should be that fast, try a smaller CFL number or a finer grid");
    warned_step_ = true;
  }
  return warnings;
}

BuriedParticles buried_particles(const State& state, const Scene& scene, const Boundary& boundary) {
  struct Found {
    std::uint64_t count = 0;
    Particle first{};  // by number
    void add(std::uint64_t more, const Particle& p) {
      if (count == 0 || p.id < first.id) first = p;
      count += more;
    }
  } found;
  std::visit(
      [&](const auto& b) {
        state.grid.for_each_particle([&](const Particle& p) {
          if (covers_cube_around(b, position_of(p), state.grid.cell_size(), state.time)) found.add(1, p);
        });
      },
      boundary);
  Message mine;
  put(mine, std::exchange(found, {}));
  for (const Message& message : state.grid.ranks().gather(std::move(mine))) {
    if (const auto other = MessageReader(message).get<Found>(); other.count > 0) found.add(other.count, other.first);
  }
  if (found.count == 0) return {};
  return {found.count, position_text(found.first, scene)};
}

}  // namespace mpm
