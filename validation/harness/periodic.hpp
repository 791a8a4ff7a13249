#pragma once
/// Periodic surroundings: a box whose particles are continued periodically, so that nothing bounds it and no exact value is imposed.

#include <cmath>
#include <vector>

#include "libmpm/core/step.hpp"

namespace mpm::validation {

/// Particles of the periodic continuation, within `margin` of the box, are renewed before every step: copies of the particles of the box,
/// moved by whole periods. The margin is 2.5 cells: particles of the box touch nodes up to one cell beyond it, which particles up to 2.5
/// cells beyond it touch, too.
class PeriodicBox {
 public:
  /// @param low       corner of the box, m
  /// @param period    m; 0 along an axis that is not periodic
  /// @param first_id  identity numbers from here on are free for copies
  PeriodicBox(const Vec3& low, const Vec3& period, double margin, std::uint64_t first_id)
      : low_(low), period_(period), margin_(margin), first_id_(first_id) {}

  /// Whether a particle is one of the box, and no copy.
  [[nodiscard]] bool owns(const Particle& p) const { return p.id < first_id_; }

  /// Brings back what has left the box, on the other side, and renews the copies.
  void renew(State& state) const {
    std::vector<Particle> fresh;
    for (const auto b : state.grid.occupied_blocks()) {
      ParticleBin& particles = state.grid.block(b).particles;
      for (int s = particles.count() - 1; s >= 0; --s) {
        if (!owns(particles[s])) {
          state.grid.remove(b, s);
          continue;
        }
        Particle p = particles[s];
        if (bring_back(p)) {
          state.grid.remove(b, s);
          fresh.push_back(p);
        }
        copy(p, fresh);
      }
    }
    for (const Particle& p : fresh) state.grid.insert(p);
    state.grid.refresh();
  }

 private:
  /// @returns whether the particle was moved
  bool bring_back(Particle& p) const {
    bool moved = false;
    for (int a = 0; a < 3; ++a) {
      if (period_[a] == 0.0) continue;
      const double periods = std::floor((p.position[a] - low_[a]) / period_[a]);
      p.position[a] -= periods * period_[a];
      moved |= periods != 0.0;
    }
    return moved;
  }
  void copy(const Particle& p, std::vector<Particle>& copies) const {
    const auto reach = [&](int axis) { return period_[axis] > 0.0 ? static_cast<int>(std::ceil(margin_ / period_[axis])) : 0; };
    const int nx = reach(0), ny = reach(1), nz = reach(2);
    std::uint64_t number = 0;
    for (int k = -nz; k <= nz; ++k)
      for (int j = -ny; j <= ny; ++j)
        for (int i = -nx; i <= nx; ++i, ++number) {
          if (i == 0 && j == 0 && k == 0) continue;
          const Vec3 at = Vec3(p.position[0], p.position[1], p.position[2]) + Vec3(i, j, k).cwiseProduct(period_);
          bool near = true;
          for (int a = 0; a < 3; ++a) near &= period_[a] == 0.0 || (at[a] - low_[a] >= -margin_ && at[a] - low_[a] <= period_[a] + margin_);
          if (!near) continue;
          Particle q = p;
          for (int a = 0; a < 3; ++a) q.position[a] = at[a];
          q.id = first_id_ * (number + 1) + p.id;
          copies.push_back(q);
        }
  }
  Vec3 low_, period_;
  double margin_;
  std::uint64_t first_id_;
};

}  // namespace mpm::validation
