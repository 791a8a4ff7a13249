#pragma once
/// Where the particles of a body or of the conveyor lie within the cells of their lattice.

#include <cmath>
#include <cstdint>
#include <span>

#include "libmpm/base/types.hpp"

namespace mpm {

/// How particles are placed: one in each cell of a lattice, or one a cell on average.
enum class Lattice : std::uint8_t {
  staggered,  ///< layers are shifted against each other, so that particles do not follow one another on the same lines
  aligned,    ///< in the middle of every cell
  random      ///< anywhere, not too near to each other: random_points
};

/// A point of the unit square, both coordinates in [0, 1).
struct R2Point {
  double a, b;  ///< fractional parts of 1/2 + n/g and 1/2 + n/g^2, g^3 = g + 1
};

/// @param n  number of the point
inline R2Point r2_point(double n) {
  constexpr double g = 1.32471795724474602596;  // the plastic number
  const auto fraction = [](double x) { return x - std::floor(x); };
  return {fraction(0.5 + n / g), fraction(0.5 + n / (g * g))};
}

/// Least distance of two random points, in cells of the lattice; at most 0.90 is possible with one point a cell on average, and the last
/// darts before that find no place for long.
inline constexpr double random_distance = 0.82;
/// Random points repeat after this number of cells along every axis.
inline constexpr long random_period = 32;

/// Points of Poisson discs (blue noise): darts thrown at random, of which those stay that are no nearer to any before them than
/// random_distance, until there is one a cell on average (Cook, ACM Trans. Graph. 5, 1986). They are the same in every program.
/// @param i, j, k  number of the cell, at least 0
/// @returns the points of the cell, from its middle, in cells: each coordinate between -1/2 and 1/2
std::span<const Vec3> random_points(long i, long j, long k);

}  // namespace mpm
