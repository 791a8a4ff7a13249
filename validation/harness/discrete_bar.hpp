#pragma once
/// The linear bar of particles on a grid in one dimension, lengths in cells, without the library: references for the error of the grid.

#include <vector>

namespace mpm::validation {

/// Particles at equal distances from x = 0 on, `per_axis` a cell, and the nodes 1 .. `nodes`; those before and behind are at rest.
/// Quadratic splines w; the gradient of the linear momentum of the particles is the sum of 4 w (x_i - x).
struct DiscreteBar {
  DiscreteBar(int cells, int per_axis, int nodes);
  using Rows = std::vector<std::vector<double>>;
  Rows gradient;             ///< by particle and node
  Rows stiffness;            ///< gradient^T gradient
  std::vector<double> mass;  ///< of the nodes: sum of w over the particles
  /// x of stiffness x = b
  [[nodiscard]] std::vector<double> solve(std::vector<double> b) const;
};

}  // namespace mpm::validation
