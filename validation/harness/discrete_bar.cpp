#include "validation/harness/discrete_bar.hpp"

#include <cmath>

namespace mpm::validation {

DiscreteBar::DiscreteBar(int cells, int per_axis, int nodes) {
  const auto n = static_cast<std::size_t>(nodes);
  const std::vector<double> zeros(n, 0.0);
  gradient.assign(static_cast<std::size_t>(cells * per_axis), zeros);
  stiffness.assign(n, zeros);
  mass = zeros;
  for (std::size_t p = 0; p < gradient.size(); ++p) {
    std::vector<double>& g = gradient[p];
    for (std::size_t i = 0; i < n; ++i) {
      const double xi = static_cast<double>(i + 1) - (static_cast<double>(p) + 0.5) / per_axis, a = std::abs(xi);
      const double w = a < 0.5 ? 0.75 - a * a : a < 1.5 ? 0.5 * (1.5 - a) * (1.5 - a) : 0.0;
      mass[i] += w;
      g[i] = 4.0 * w * xi;
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; g[i] != 0.0 && j < n; ++j) stiffness[i][j] += g[i] * g[j];
  }
}

std::vector<double> DiscreteBar::solve(std::vector<double> b) const {
  Rows a = stiffness;  // positive definite: elimination without pivots
  for (std::size_t k = 0; k < b.size(); ++k)
    for (std::size_t i = k + 1; i < b.size(); ++i) {
      const double factor = a[i][k] / a[k][k];
      if (factor == 0.0) continue;
      for (std::size_t j = k; j < b.size(); ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  for (std::size_t k = b.size(); k-- > 0;) {
    for (std::size_t j = k + 1; j < b.size(); ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

}  // namespace mpm::validation
