#pragma once
/// A run on several ranks: the first rank runs the case like a single rank; the others follow its instructions.

#include "libmpm/core/state.hpp"
#include "libmpm/driver/case.hpp"

namespace mpm {

class BlockExchange;

/// Executes the first rank's instructions until Task::end; called on the other ranks. @param c  the case that the first runs
/// @throws Error if only this rank fails: the others then wait for it, and the caller must end them
void work_on(const Case& c, BlockExchange& ranks);

/// What each rank computed and sent since the start or --resume, as JSON: the content of ranks.json. Called on the first rank.
std::string report_of_ranks(const State& state, BlockExchange& ranks);

}  // namespace mpm
