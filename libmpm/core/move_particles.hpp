#pragma once
/// The particles' part of a step, in one loop over the blocks.

#include "libmpm/core/boundary_impulses.hpp"
#include "libmpm/core/state.hpp"
#include "libmpm/core/step_times.hpp"
#include "libmpm/core/transfer.hpp"

namespace mpm {

/// Updates velocity, position and stress of all particles. Those in solids return to the surface, those that left their block go into its
/// outbox, those that left the domain are removed. Particles of outer blocks come last, when the nodes of other ranks have arrived.
/// @param impulses  those by which boundaries hold particles at their surface are added. @param times  may be null. @returns what left the
/// domain, on all ranks
/// @throws UnstableError as step()
FluxTotals move_particles(State& state, const Scene& scene, const TransferOptions& options, ImpulseRecord& impulses, StepTimes* times);

}  // namespace mpm
