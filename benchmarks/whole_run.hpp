#pragma once
/// A run from start to end into a folder, with frames, series and checkpoints.

#include <cstddef>

#include "libmpm/base/precision.hpp"

namespace mpm::benchmarks {

/// Time and memory of a run.
struct WholeRun {
  double start_up = 0.0;      ///< s, from the call to the first step
  double seconds = 0.0;       ///< from the call to the end
  double step_seconds = 0.0;  ///< part of `seconds` in steps
  double particle_steps = 0.0;
  double particles = 0.0;   ///< at the end
  double peak_bytes = 0.0;  ///< memory of the run, without that of the process before it
};

/// The avalanche of examples/avalanche_fr3.toml on a coarser or finer grid, 0.2 s of flow, 5 frames, a checkpoint at the end; the default
/// numerics (AFLIP, contact at surfaces). @param particles  about so many. @throws Error
WholeRun run_avalanche(std::size_t particles, int threads, Precision precision);

}  // namespace mpm::benchmarks
