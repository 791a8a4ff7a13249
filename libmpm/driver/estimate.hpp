#pragma once
/// What a case will cost, before it is run: for `mpm check`, and to refuse what the machine cannot hold.

#include "libmpm/driver/case.hpp"

namespace mpm {

/// Size and work of a case.
struct Estimate {
  double particles;       ///< at the fullest moment
  double cells;           ///< occupied grid cells
  double wave_speed;      ///< c_P = sqrt((K + 4G/3) / rho_0), m/s
  double time_step;       ///< s, for the largest speed that can be foreseen
  double steps;           ///< in the whole duration
  double particle_steps;  ///< particles * steps
  double samples;         ///< rows of series.csv
  double frames;          ///< stored
  double memory_bytes;    ///< at its most: particles with their part of the grid while a file is written, and the series
  double disk_bytes;      ///< of everything that the run leaves
  double wall_time_s;     ///< at assumed_particle_steps_per_s
};

/// Memory of a particle at the run's peak, while a file is written, rounded up. Measured: 366 in an avalanche of 510,000 on a mast, 247 in
/// a column at rest of 512,000. Of the 366, pages of records take 197, outboxes with room for 64 and more in each block 35, the layers of
/// the inflow 23, the order of the particles for a file 16, nodes 16; the rest are lists, the piece that is written, and free memory.
inline constexpr double assumed_bytes_per_particle = 400.0;
/// Speed that the project asks of two cores (not measured on this machine).
inline constexpr double assumed_particle_steps_per_s = 10e6;

/// Volumes of the bodies or of the conveyor's filled window (strip: L = v t + 3 m, Table 2 of the paper) times particles per volume;
/// dt = cfl dx / (c_P + |v|), |v| from initial speeds and the height that can be fallen. An estimate: jets and piles are not foreseen.
[[nodiscard]] Estimate estimate(const Case& spec);

/// Main memory of this machine, bytes.
[[nodiscard]] double physical_memory_bytes();

/// Limits that hold on every machine, whatever its memory. Frames are numbered by five digits; a series of the given length is 20 GB;
/// at the given steps and years no run is worth waiting for.
/// @{
inline constexpr double most_samples = 1e8, most_frames = 99999.0, most_steps = 1e12, most_years = 10.0;
/// @}

/// @throws ConfigError if the estimate needs more memory than limit_bytes; the message names what to change
void require_memory(const Estimate& need, double limit_bytes);

/// @throws ConfigError with everything that makes a run impossible, one a line: the limits above, and the memory. Allocates nothing.
void require_feasible(const Estimate& need, double limit_bytes);

}  // namespace mpm
