#pragma once
/// A run from start to end into a folder, with frames, series and checkpoints; and its steps alone.

#include <cstddef>

#include "libmpm/base/types.hpp"
#include "libmpm/driver/case.hpp"

namespace mpm::benchmarks {

/// The avalanche of examples/avalanche_fr3.toml on a coarser or finer grid; the default numerics (AFLIP, contact at surfaces), 50 rows of
/// the series and 5 frames per second. @param particles  about so many; 113,000: the grid of the example. @param duration  of the flow, s
Case avalanche_case(std::size_t particles, Precision precision, double duration);

/// Work and elapsed time.
struct Pace {
  double seconds = 0.0;
  double particle_steps = 0.0;
  [[nodiscard]] double speed() const { return particle_steps / seconds; }  ///< particle-steps per second
};

/// Time and memory of a run.
struct WholeRun {
  Pace pace;                ///< from the call to the end, all files included
  double start_up = 0.0;    ///< s, from the call to the end of the first step
  double particles = 0.0;   ///< at the end
  double peak_bytes = 0.0;  ///< memory of the run, without that of the process before it
};

/// @throws Error
WholeRun whole_run(const Case& c, int threads);

/// The steps of the same run, which have the same bits: without observers, files and the start. @throws Error
Pace steps_alone(const Case& c, int threads);

}  // namespace mpm::benchmarks
