#pragma once
/// The R2 sequence: points that fill the unit square evenly, however many there are (M. Roberts, The unreasonable effectiveness of
/// quasirandom sequences, 2018). Layers of particles are shifted by it against each other.

#include <cmath>

namespace mpm {

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

}  // namespace mpm
