#pragma once
/// B-spline weights of the nodes at a fixed position, for stencils.

#include <array>

#include "libmpm/base/bspline.hpp"

namespace mpm {

/// Weights of nodes first .. first + 2 along one axis.
struct AxisWeights {
  /// @param x  place, in cells
  explicit AxisWeights(double x) : first(base_node(x)) {
    const BsplineWeights<double> n = bspline_weights(x - first);
    w = {n.n0, n.n1, n.n2};
  }
  int first;                  ///< node
  std::array<double, 3> w{};  ///< weights, their sum is 1
};

}  // namespace mpm
