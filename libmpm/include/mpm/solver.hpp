#pragma once
/// The time step: state, scene, step().

#include <functional>
#include <optional>

#include "mpm/boundary.hpp"
#include "mpm/grid.hpp"
#include "mpm/materials/any_material.hpp"
#include "mpm/transfer.hpp"

namespace mpm {

/// Sums over particles that entered or left.
struct Passage {
  std::uint64_t count = 0;
  std::uint64_t downstream = 0;  ///< of these: across the domain's end at x_max
  double mass = 0.0;             ///< kg
  Vec3 momentum = Vec3::Zero();  ///< N s
  double energy = 0.0;           ///< kinetic and elastic (see diagnostics.hpp), J
  Passage& operator+=(const Passage& other) {
    count += other.count;
    downstream += other.downstream;
    mass += other.mass;
    momentum += other.momentum;
    energy += other.energy;
    return *this;
  }
};

/// Everything that changes. Copying it is not offered (it may be gigabytes); checkpoints serialise it.
struct State {
  explicit State(double cell_size) : grid(cell_size) {}
  Grid grid;
  double time = 0.0;             ///< s
  std::uint64_t step = 0;        ///< steps done
  std::uint64_t next_id = 0;     ///< identity number of the next particle
  std::uint64_t fed_layers = 0;  ///< layers that the feed has released so far
  double max_speed = 0.0;        ///< fastest particle, m/s
  Passage entered, left;         ///< since t = 0, without the initial particles
};

/// Brings fresh particles; called at the start of every step. Returns what entered.
class Feed {
 public:
  virtual ~Feed() = default;
  virtual Passage release(State& state) const = 0;
};

/// Everything that stays: law, boundaries, gravity, numerics.
struct Scene {
  AnyMaterial material;
  std::vector<Boundary> boundaries;
  std::optional<std::size_t> obstacle;  ///< index of the boundary whose force is reported
  std::shared_ptr<const Feed> feed;     ///< may be empty
  Vec3 gravity = Vec3::Zero();          ///< m/s^2
  Vec3 domain_min = Vec3::Constant(-1e3), domain_max = Vec3::Constant(1e3);
  bool mirror_x = false, mirror_y = false;
  Vec3 offset = Vec3::Zero();  ///< m: a point x of the case stands at x + offset in State and Scene ([numerics] grid_offset_cells)
  Transfer transfer = Transfer::apic;
  double flip_ratio = 0.0;
  double cfl = 0.4;
};

/// What one step did to the momentum: P(t+dt) - P(t) = entered + gravity - sum of impulses - left, to round-off
/// (with a mirror plane: in the directions along it).
struct StepReport {
  double dt = 0.0;
  Vec3 gravity_impulse = Vec3::Zero();  ///< N s
  std::vector<Impulse> impulses;        ///< taken by each boundary of the scene
  LayerImpulses obstacle_layers;        ///< of these the obstacle's, by grid layer
  Passage entered, left;
};

/// Largest stable step: cfl dx / (c_P + |v|max), and with a viscosity eta at most cfl rho_0 dx^2 / (2 eta).
/// The second is the limit of explicit diffusion: a mode of the grid whose velocity decays at the rate a and that swings at omega is stable
/// up to omega^2 dt^2/4 + a dt/2 = 1. With a <= 4/3 (3/2) eta/(rho dx^2) (quadratic B-splines) that is about dt = rho dx^2/eta for a full
/// cell; cells with few particles take less: 0.6 rho dx^2/eta was seen to fail and 0.4 to hold at cfl 0.4, where this gives 0.2.
double stable_time_step(const AnyMaterial& material, double cfl, double cell_size, double max_speed);
/// The same for a state. @throws UnstableError if it has collapsed
double stable_time_step(const State& state, const Scene& scene);

/// One explicit step of symplectic Euler, updated Lagrangian with the stress last (Stomakhin et al. 2013; Sect. 2.1.1 of the paper).
/// @throws UnstableError naming particle, position and time, when a particle is not finite, is turned inside out (det(I + dt C) <= 0) or
/// moves by more than a block
StepReport step(State& state, const Scene& scene, double dt);

/// Steps until `time`, in steps of at most the stable size, the last two evened out so that `time` is met to the bit.
/// @param after called after every step
void advance(State& state, const Scene& scene, double time, const std::function<void(const StepReport&)>& after = {});

}  // namespace mpm
