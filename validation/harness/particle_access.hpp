#pragma once
/// Changing particles between steps: initial fields, body forces, damping.

#include "mpm/solver.hpp"

namespace mpm::validation {

/// Calls f(Particle&) for every particle. Positions must stay within their cell: the order by cell is not rebuilt.
template <class F>
void change_particles(State& state, F&& f) {
  for (const auto b : state.grid.occupied_blocks()) {
    ParticleBin& particles = state.grid.block(b).particles;
    for (int s = 0; s < particles.count(); ++s) f(particles[s]);
  }
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
