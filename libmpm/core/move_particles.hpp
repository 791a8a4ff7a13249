#pragma once
/// The particles' part of a step, in one loop over the blocks.

#include "libmpm/core/boundary_impulses.hpp"
#include "libmpm/core/state.hpp"
#include "libmpm/core/step_times.hpp"
#include "libmpm/core/transfer.hpp"

namespace mpm {

/// Updates velocity, position and stress of all particles, and holds them outside of solids. Puts those that left their block into its
/// outbox, and removes those that left the domain. Particles of outer blocks come last, when the nodes of other ranks have arrived.
/// @param impulses  those on solids are added. @param times  may be null. @returns what left the domain, on all ranks
/// @throws UnstableError as step()
FluxTotals move_particles(State& state, const Scene& scene, const TransferOptions& options, ImpulseRecord& impulses, StepTimes* times);

}  // namespace mpm
