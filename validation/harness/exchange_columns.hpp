#pragma once
/// Names of the columns in the files of exported cases and of their results (docs/other-solvers.md).

#include <cstddef>
#include <string>
#include <vector>

#include "validation/harness/setup.hpp"

namespace mpm::validation {

inline const std::vector<std::string> position_columns{"x_m", "y_m", "z_m"}, velocity_columns{"vx_m_s", "vy_m_s", "vz_m_s"};
inline const std::vector<std::string> stress_columns{"stress_xx_pa", "stress_yy_pa", "stress_zz_pa",
                                                     "stress_xy_pa", "stress_xz_pa", "stress_yz_pa"};
inline const std::vector<std::string> force_columns{"time_s", "boundary", "force_x_n", "force_y_n", "force_z_n"};  ///< of forces.csv

/// Columns that the particles of a state must have. A solver with particles of its own gives mass_kg; otherwise id identifies the particle
/// of t = 0 it is.
std::vector<std::string> state_columns(const ParticleFields& fields, bool with_id);

/// The number of a state in the names of files and groups: "0001" for the first.
std::string state_number(std::size_t index);

}  // namespace mpm::validation
