#pragma once
/// Quadratic B-spline weights. A particle at grid coordinate x/dx touches the three nodes base, base+1, base+2 per axis, where
/// base = floor(x/dx - 1/2); its offset f = x/dx - base lies in [1/2, 3/2].
///
/// N_0 = (3/2 - f)^2 / 2,  N_1 = 3/4 - (f - 1)^2,  N_2 = (f - 1/2)^2 / 2      (Steffen, Kirby & Berzins 2008)
///
/// Sum N_i = 1, sum N_i (i - f) = 0, sum N_i (i - f)^2 = 1/4: the last makes the affine matrix of APIC the constant
/// D_p = dx^2/4 I (Jiang et al. 2015), so that C_p = 4/dx^2 sum_i w_ip v_i (x_i - x_p)^T.

#include <algorithm>

#include "libmpm/base/lanes.hpp"

namespace mpm {

/// The three weights along one axis.
template <class T>
struct BsplineWeights {
  T n0, n1, n2;  ///< N_0, N_1, N_2: of nodes base, base + 1, base + 2
};

/// @param f offset from the base node in cells, in [1/2, 3/2]
template <class T>
inline BsplineWeights<T> bspline_weights(const T& f) {
  const T a = 1.5 - f, b = f - 1.0, c = f - 0.5;
  return {0.5 * a * a, 0.75 - b * b, 0.5 * c * c};
}

/// Integral of the B-spline of a node from y to its end, y in cells from the node.
inline double bspline_tail(double y) {
  if (y < 0.0) return 1.0 - bspline_tail(-y);
  const double end = std::max(0.0, 1.5 - y);
  return y < 0.5 ? 0.5 - y * (0.75 - y * y / 3.0) : end * end * end / 6.0;
}

/// Node index of the first of the three nodes; at an exact tie either choice is correct, because N is smooth there.
inline std::int32_t base_node(double grid_coordinate) { return static_cast<std::int32_t>(std::floor(grid_coordinate - 0.5)); }

}  // namespace mpm
