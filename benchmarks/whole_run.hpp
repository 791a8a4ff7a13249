#pragma once
/// A run from start to end into a folder, as users do it: with frames, series and checkpoints.

#include <cstddef>

#include "libmpm/base/precision.hpp"

namespace mpm::benchmarks {

/// What a run took.
struct WholeRun {
  double start_up = 0.0;      ///< s, from the call until the first step may begin
  double seconds = 0.0;       ///< from the call to the end
  double step_seconds = 0.0;  ///< of these, in steps
  double particle_steps = 0.0;
  double particles = 0.0;   ///< at the end
  double peak_bytes = 0.0;  ///< memory that the run needed beyond what the process held before
};

/// The avalanche of examples/avalanche_fr3.toml on a coarser or finer grid, 0.2 s of flow, 5 frames, a checkpoint at the end; the default
/// numerics (AFLIP, contact at surfaces). @param particles  about so many. @throws Error
WholeRun run_avalanche(std::size_t particles, int threads, Precision precision);

}  // namespace mpm::benchmarks
