#pragma once
/// Bounds of the values in a case: wide enough for any laboratory or mountain, and narrow enough that volumes, counts and energies cannot
/// overflow.

namespace mpm {

inline constexpr double longest_length = 1e5;  ///< m, of a length or a coordinate
inline constexpr double fastest_speed = 1e3;   ///< m/s

}  // namespace mpm
