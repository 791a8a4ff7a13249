#pragma once
/// The time step.

#include <functional>
#include <vector>

#include "libmpm/core/state.hpp"

namespace mpm {

/// Momentum balance of one step: P(t+dt) - P(t) = entered + gravity - sum of impulses - left, to round-off
/// (with a mirror plane: in the directions along it).
struct StepReport {
  double dt = 0.0;                      ///< s
  Vec3 gravity_impulse = Vec3::Zero();  ///< N s
  std::vector<Impulse> impulses;        ///< on each boundary of the scene
  std::vector<LayerImpulses> layers;    ///< on the boundaries in Scene::layered, by grid layer
  FluxTotals entered, left;             ///< particles inserted by the source, and those that left the domain
};

/// Wall time of the phases of a step, s. Blocks are moved phase by phase within one parallel loop: its wall time is divided among its
/// phases by the time that the threads spent in them.
struct StepTimes {
  double source = 0.0, particle_to_grid = 0.0, grid_update = 0.0, grid_to_particle = 0.0, stress = 0.0, sort = 0.0;  ///< s
  /// Sum of the phases, s.
  [[nodiscard]] double total() const { return source + particle_to_grid + grid_update + grid_to_particle + stress + sort; }
};

/// Largest stable step: cfl dx / (c_P + |v|max), and with a viscosity eta at most cfl rho_0 dx^2 / (2 eta).
/// The second is the limit of explicit diffusion: a mode of the grid with frequency omega and damping rate a is stable up to
/// omega^2 dt^2/4 + a dt/2 = 1. With a <= 4/3 (3/2) eta/(rho dx^2) (quadratic B-splines) that is about dt = rho dx^2/eta for a full
/// cell; cells with few particles take less: in tests 0.6 rho dx^2/eta was unstable and 0.4 stable at cfl 0.4, where this formula gives
/// 0.2.
double stable_time_step(const AnyMaterial& material, double cfl, double cell_size, double max_speed);
/// The same for a state. @throws UnstableError if the step has collapsed
double stable_time_step(const State& state, const Scene& scene);

/// One explicit step of symplectic Euler, updated Lagrangian with the stress last (Stomakhin et al. 2013; Sect. 2.1.1 of the paper).
/// @throws UnstableError naming particle, position and time, when a particle is not finite, is turned inside out (det(I + dt C) <= 0) or
/// moves by more than a block
/// @param times  not null: the time that each phase took is added to it
StepReport step(State& state, const Scene& scene, double dt, StepTimes* times = nullptr);

/// Steps until `time`, in steps of at most the stable size. The last two have equal length, so that `time` is reached exactly.
/// @param after called after every step
void advance(State& state, const Scene& scene, double time, const std::function<void(const StepReport&)>& after = {});

}  // namespace mpm
