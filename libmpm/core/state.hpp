#pragma once
/// State (what a step changes), Scene (constant during a run), ParticleSource (inserts particles), and StepReport (what a step reports).

#include <cstdint>
#include <memory>
#include <vector>

#include "libmpm/core/grid_update.hpp"
#include "libmpm/core/numerics.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {

/// Sums over particles that entered or left.
struct FluxTotals {
  std::uint64_t count = 0;          ///< particles
  std::uint64_t through_x_max = 0;  ///< of these: left across the end of the domain at x_max
  double mass = 0.0;                ///< kg
  Vec3 momentum = Vec3::Zero();     ///< N s
  double energy = 0.0;              ///< kinetic and elastic (see diagnostics.hpp), J
  /// Adds other particles that entered or left.
  FluxTotals& operator+=(const FluxTotals& other) {
    count += other.count;
    through_x_max += other.through_x_max;
    mass += other.mass;
    momentum += other.momentum;
    energy += other.energy;
    return *this;
  }
};

/// Everything that a step changes. It cannot be copied (it may have gigabytes); checkpoints serialise it.
struct State {
  /// Without particles. @param cell_size  dx, m; @param precision  of the particles
  explicit State(double cell_size, Precision precision = Precision::double_precision) : grid(cell_size, precision) {}
  Grid grid;                       ///< with the particles
  double time = 0.0;               ///< s
  std::uint64_t step = 0;          ///< steps done
  std::uint64_t next_id = 0;       ///< identity number of the next particle
  std::uint64_t source_count = 0;  ///< counter of the particle source, which defines its unit
  double max_speed = 0.0;          ///< fastest particle, m/s
  FluxTotals entered, left;        ///< since t = 0, without the initial particles
};

/// Inserts particles into a state: at t = 0, and at the start of every step. A source is immutable; State::source_count stores its
/// progress.
class ParticleSource {
 public:
  virtual ~ParticleSource() = default;
  /// Inserts the particles of t = 0. State::entered does not count them.
  virtual void fill(State& state) const = 0;
  /// Inserts the particles that are due at state.time. @returns their sums
  virtual FluxTotals release(State& state) const = 0;
};

/// Everything that is constant during a run: law, boundaries, gravity, numerics.
struct Scene {
  AnyMaterial material;                          ///< the law, of all particles
  std::vector<Boundary> boundaries;              ///< in the order in which they act
  std::vector<std::size_t> layered;              ///< indices of the boundaries whose impulses are also recorded by grid layer
  std::shared_ptr<const ParticleSource> source;  ///< may be empty
  Vec3 gravity = Vec3::Zero();                   ///< m/s^2
  Vec3 domain_min = Vec3::Constant(-1e3), domain_max = Vec3::Constant(1e3);  ///< m; particles that leave are removed and counted
  MirrorPlanes mirror;                                                       ///< only one side is computed
  Vec3 offset = Vec3::Zero();  ///< m: shift of the whole scene against the grid. What a user calls x is x + offset in State and Scene
  StepNumerics numerics = {};  ///< of the transfers and the size of a step
};

/// Momentum balance of one step: P(t+dt) - P(t) = entered + gravity - sum of impulses - left, to round-off
/// (with a mirror plane: in the directions along it).
struct StepReport {
  double dt = 0.0;                      ///< s
  Vec3 gravity_impulse = Vec3::Zero();  ///< N s
  std::vector<Impulse> impulses;        ///< on each boundary of the scene
  std::vector<LayerImpulses> layers;    ///< on the boundaries in Scene::layered, by grid layer
  FluxTotals entered, left;             ///< particles inserted by the source, and those that left the domain
};

}  // namespace mpm
