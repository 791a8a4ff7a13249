#pragma once
/// What a case will cost, before it is run: for `mpm check`, and to refuse what the machine cannot hold.

#include "mpm/case.hpp"

namespace mpm {

struct Estimate {
  double particles;       ///< at the fullest moment
  double cells;           ///< occupied grid cells
  double wave_speed;      ///< c_P = sqrt((K + 4G/3) / rho_0), m/s
  double time_step;       ///< s, for the largest speed that can be foreseen
  double steps;           ///< in the whole duration
  double particle_steps;  ///< particles * steps
  double memory_bytes;    ///< particles with their share of the grid
  double wall_time_s;     ///< at assumed_particle_steps_per_s
};

/// Memory of a particle (192 bytes, kept twice while sorting where it matters) with its share of the grid.
inline constexpr double assumed_bytes_per_particle = 300.0;
/// Speed that the project asks of two cores (not measured on this machine).
inline constexpr double assumed_particle_steps_per_s = 10e6;

/// Volumes of the bodies or of the conveyor's filled window (strip: L = v t + 3 m, Table 2 of the paper) times particles per volume;
/// dt = cfl dx / (c_P + |v|), |v| from initial speeds and the height that can be fallen. An estimate: jets and piles are not foreseen.
[[nodiscard]] Estimate estimate(const Case& spec);

/// Main memory of this machine, bytes.
[[nodiscard]] double physical_memory_bytes();

/// @throws ConfigError if the estimate needs more memory than limit_bytes; says what to change
void require_memory(const Estimate& need, double limit_bytes);

}  // namespace mpm
