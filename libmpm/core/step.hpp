#pragma once
/// The time step.

#include <functional>

#include "libmpm/core/state.hpp"
#include "libmpm/core/step_times.hpp"
#include "libmpm/core/time_step.hpp"

namespace mpm {

/// One explicit step of symplectic Euler, updated Lagrangian with the stress last (Stomakhin et al. 2013; Sect. 2.1.1 of the paper).
/// @throws UnstableError naming particle, position and time, when a particle is not finite, is turned inside out (det(I + dt C) <= 0) or
/// moves by more than a block
/// @param times  not null: the time that each phase took is added to it
StepReport step(State& state, const Scene& scene, double dt, StepTimes* times = nullptr);

/// Steps until `time`, in steps of at most the stable size. The last two have equal length, so that `time` is reached exactly.
/// @param after called after every step
void advance(State& state, const Scene& scene, double time, const std::function<void(const StepReport&)>& after = {});

}  // namespace mpm
