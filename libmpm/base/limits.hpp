#pragma once
/// Bounds of what a case may ask for: wide enough for any laboratory or mountain, narrow enough that volumes, counts and energies stay far
/// from overflow.

namespace mpm {

inline constexpr double longest_length = 1e5;  ///< m, of a length or a coordinate
inline constexpr double fastest_speed = 1e3;   ///< m/s

}  // namespace mpm
