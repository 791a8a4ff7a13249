#pragma once
/// Changing particles between steps: initial fields, body forces, damping.

#include <cmath>
#include <numbers>

#include "libmpm/core/step.hpp"

namespace mpm::validation {

/// One step towards rest: gravity on a smooth ramp from 0 at t = 0 to all of it at `ramp`, then every velocity falls as exp(-damping dt).
inline StepReport settling_step(State& state, Scene& scene, const Vec3& full_gravity, double ramp, double damping) {
  const double dt = stable_time_step(state, scene);
  const double fraction = state.time >= ramp ? 1.0 : 0.5 * (1.0 - std::cos(std::numbers::pi * state.time / ramp));
  scene.gravity = fraction * full_gravity;
  StepReport report = step(state, scene, dt);
  const double keep = std::exp(-damping * dt);
  state.grid.change_particles([keep](Particle& p) {
    for (double& v : p.velocity) v *= keep;
    for (double& a : p.affine) a *= keep;
  });
  return report;
}

/// Position at the start by identity number: the reference coordinate X of each particle.
inline std::vector<Vec3> reference_positions(const State& state) {
  std::vector<Vec3> x(state.next_id);
  state.grid.for_each_particle([&](const Particle& p) { x[p.id] = Vec3(p.position[0], p.position[1], p.position[2]); });
  return x;
}

inline MaterialState<double> material_state(const Particle& p) {
  return {{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
}

}  // namespace mpm::validation
