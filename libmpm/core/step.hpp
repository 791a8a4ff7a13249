#pragma once
/// The time step, and its size.

#include <functional>

#include "libmpm/core/state.hpp"
#include "libmpm/core/step_times.hpp"

namespace mpm {

/// One explicit step of symplectic Euler, updated Lagrangian with the stress last (Stomakhin et al. 2013; Sect. 2.1.1 of the paper).
/// @throws UnstableError naming particle, position and time, when a particle is not finite, is turned inside out (det(I + dt C) <= 0) or
/// moves by more than a block
/// @param times  not null: the time that each phase took is added to it
StepReport step(State& state, const Scene& scene, double dt, StepTimes* times = nullptr);

/// Largest stable step: the least of (1) cfl dx / (c_P + |v|max), (2) 0.92 dx / sqrt(3 K/rho_0), and with a viscosity eta (3)
/// cfl rho_0 dx^2 / (2 eta) and (4) 0.23 rho_0 dx^2 / eta.
/// (2) and (4) are for a particle without neighbours. A step changes its velocity gradient by dt V_0/m (4/dx^2) tau, because
/// the sum of grad w_i (x_i - x_p) over the nodes is the identity, wherever the particle is. So its pressure oscillates with omega^2 =
/// 12 K/(rho_0 dx^2), which is stable up to omega dt = 2, and viscosity damps its shear by 8 eta/(rho_0 dx^2), stable up to 2/dt. In slow
/// flows (1) is beyond it for CFL 1, and bits of cohesive snow burst. The correction of lumped masses (lumped_mass.hpp) doubles
/// this response. So beside solids that need it (2) has 0.65, but for laws that keep compaction: snow yields first; and (4) has
/// 0.115.
/// (3) is the limit of explicit diffusion: a mode of the grid with frequency omega and damping rate a is stable up to
/// omega^2 dt^2/4 + a dt/2 = 1. With a <= 4/3 (3/2) eta/(rho dx^2) (quadratic B-splines) that is about dt = rho dx^2/eta for a full
/// cell.
/// @param corrected  whether boundaries need the correction of lumped masses
double stable_time_step(const AnyMaterial& material, double cfl, double cell_size, double max_speed, bool corrected = false);
/// The same for a state. @throws UnstableError if the step has collapsed
double stable_time_step(const State& state, const Scene& scene);

/// Steps until `time`, in steps of at most the stable size. The last two have equal length, so that `time` is reached exactly.
/// @param after called after every step
void advance(State& state, const Scene& scene, double time, const std::function<void(const StepReport&)>& after = {});

}  // namespace mpm
