#pragma once
/// Estimated cost of a case before it is run: for `mpm check`, and to refuse cases that need more memory than the machine has.

#include "libmpm/driver/case.hpp"

namespace mpm {

/// Size and work of a case.
struct Estimate {
  double particles;       ///< largest number during the run
  double cells;           ///< occupied grid cells
  double wave_speed;      ///< c_P = sqrt((K + 4G/3) / rho_0), m/s
  double time_step;       ///< s, for the largest speed that can be predicted
  double steps;           ///< in the whole duration
  double particle_steps;  ///< particles * steps
  double samples;         ///< rows of series.csv
  double frames;          ///< stored
  double memory_bytes;    ///< largest during the run: particles, grid and series, while a file is written
  double disk_bytes;      ///< of all files of the run
  double wall_time_s;     ///< at assumed_particle_steps_per_s
};

/// Memory of a particle at the run's peak, while a file is written, rounded up. Measured: 276 in an avalanche of 510,000 on a mast, 247 in
/// a column at rest of 512,000. Of the 276, pages of records take 200, the order of the particles for a file 16, nodes 16; the rest are
/// lists, outboxes, the piece that is written, and free memory.
inline constexpr double assumed_bytes_per_particle = 400.0;
/// Required speed on two cores (not measured on this machine).
inline constexpr double assumed_particle_steps_per_s = 10e6;

/// Volumes of the bodies or of the conveyor's filled window (strip: L = v t + 3 m, Table 2 of the paper) times particles per volume;
/// dt = cfl dx / (c_P + |v|), |v| from initial speeds and the height that can be fallen. The estimate ignores jets and piles.
[[nodiscard]] Estimate estimate(const Case& spec);

/// Main memory of this machine, bytes.
[[nodiscard]] double physical_memory_bytes();

/// Limits that hold on every machine, whatever its memory. Frame numbers have five digits; a series of the given length has 20 GB; a run
/// with more steps or years would not end in useful time.
/// @{
inline constexpr double most_samples = 1e8, most_frames = 99999.0, most_steps = 1e12, most_years = 10.0;
/// @}

/// @throws ConfigError with all reasons why a run is impossible, one on each line: the limits above, and the memory. Allocates nothing.
void require_feasible(const Estimate& need, double limit_bytes);

}  // namespace mpm
