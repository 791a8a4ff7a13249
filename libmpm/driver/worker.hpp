#pragma once
/// A run by several ranks: the first rank runs the case as one rank would; the others do what it tells them.

#include "libmpm/core/state.hpp"
#include "libmpm/driver/case.hpp"

namespace mpm {

/// What a rank other than the first does until the first says that nothing follows. @param c  the case that the first runs
/// @throws Error if this rank fails alone: the others then wait for it, and the caller must end them
void work_on(const Case& c, Ranks& ranks);

/// What each rank computed and sent in this stretch of the run, as JSON: the content of ranks.json. On the first rank.
std::string report_of_ranks(const State& state);

}  // namespace mpm
