#include "validation/harness/setup.hpp"

#include <fmt/format.h>

#include "libmpm/base/error.hpp"
#include "libmpm/core/stress_update.hpp"

namespace mpm::validation {
namespace {

/// This program's own run.
RunCost solve(const Setup& setup, const Visitor& visit) {
  CaseScene scene = make_scene(setup.spec);
  State state = setup.start(setup.spec, scene);
  RunCost cost;
  Instant now;
  now.state = &state;
  now.scene = &scene;
  for (const double time : setup.times) {
    std::vector<Vec3> impulses(scene.boundaries.size(), Vec3::Zero());
    const auto after = [&](const StepReport& report) {
      for (std::size_t i = 0; i < impulses.size(); ++i) impulses[i] += report.impulses[i].linear;
      cost.particle_steps += static_cast<double>(state.grid.particle_count());
    };
    if (setup.solve) {
      const std::uint64_t steps = state.step;
      setup.solve(state, scene, time, impulses);
      cost.particle_steps += static_cast<double>((state.step - steps) * state.grid.particle_count());
    } else if (setup.time_step > 0.0) {
      const auto steps = std::lround((time - now.time) / setup.time_step);
      for (long i = 0; i < steps; ++i) after(step(state, scene, setup.time_step));
    } else {
      advance(state, scene, time, after);
    }
    now.before = now.time;
    now.time = state.time;
    now.forces.assign(impulses.begin(), impulses.end());
    for (Vec3& f : now.forces) f /= now.time - now.before;
    now.particles = setup.particles ? particle_records(state, scene) : std::vector<ParticleRecord>{};
    if (!visit(now)) break;
    ++now.index;
  }
  return cost;
}

}  // namespace

RunCost play(const CaseContext& context, const Setup& setup, const Visitor& visit) {
  if (setup.times.empty()) throw ConfigError(fmt::format("set-up {}: it has no times", setup.id));
  return context.source() == nullptr ? solve(setup, visit) : context.source()->play(setup, visit);
}

std::vector<ParticleRecord> particle_records(const State& state, const Scene& scene) {
  std::vector<ParticleRecord> records;
  records.reserve(state.grid.particle_count());
  const double density = density_of(scene.material);
  state.grid.for_each_particle([&](const Particle& p) {
    ParticleRecord r{.id = p.id,
                     .position = Vec3(p.position[0], p.position[1], p.position[2]) - scene.offset,
                     .velocity = Vec3(p.velocity[0], p.velocity[1], p.velocity[2]),
                     .mass = density * p.volume,
                     .volume_ratio = volume_ratio(scene.material, p)};
    for (int k = 0; k < 6; ++k) r.stress[k] = p.stress[k] / r.volume_ratio;
    records.push_back(r);
  });
  return records;
}

std::vector<double> even_times(double from, double to, std::size_t count) {
  std::vector<double> times;
  for (std::size_t i = 1; i <= count; ++i) times.push_back(from + (to - from) * static_cast<double>(i) / static_cast<double>(count));
  return times;
}

MassCentre mass_centre(const std::vector<ParticleRecord>& particles) {
  MassCentre c;
  for (const ParticleRecord& p : particles) {
    c.mass += p.mass;
    c.position += p.mass * p.position;
    c.velocity += p.mass * p.velocity;
  }
  c.position /= c.mass;
  c.velocity /= c.mass;
  return c;
}

std::vector<std::string> boundary_names(const Setup& setup) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < setup.spec.walls.size(); ++i) names.push_back(fmt::format("wall_{}", i + 1));
  if (setup.spec.obstacle) names.emplace_back("obstacle");
  return names;
}

}  // namespace mpm::validation
