#include "libmpm/impact/savitzky_golay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libmpm/base/error.hpp"

namespace mpm {
namespace {

/// Orthonormal polynomials of degree 0..order on `window` equally spaced points, one row each: Gram's polynomials, by orthogonalising
/// x times the previous one against all before it (twice, which is enough for round-off).
std::vector<std::vector<double>> orthonormal_polynomials(int window, int order) {
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const double half = 0.5 * (window - 1);
  std::vector<std::vector<double>> basis;
  std::vector<double> next(static_cast<std::size_t>(window), 1.0);
  for (int degree = 0; degree <= order; ++degree) {
    for (int pass = 0; pass < 2; ++pass) {
      for (const auto& b : basis) {
        const double component = dot(b, next);
        for (std::size_t i = 0; i < next.size(); ++i) next[i] -= component * b[i];
      }
    }
    const double norm = std::sqrt(dot(next, next));
    for (double& value : next) value /= norm;
    basis.push_back(next);
    for (std::size_t i = 0; i < next.size(); ++i) next[i] *= static_cast<double>(i) - half;
  }
  return basis;
}

}  // namespace

std::vector<double> savitzky_golay(std::span<const double> values, int window, int order) {
  const int n = static_cast<int>(values.size());
  if (window < 1 || window % 2 == 0 || order < 0 || order >= window || window > n) {
    throw ConfigError(
        fmt::format("savitzky_golay: window {}, order {} for {} values: the window must be odd, greater than the order and at "
                    "most the number of values",
                    window, order, n));
  }
  const auto basis = orthonormal_polynomials(window, order);
  std::vector<double> smooth(values.size(), 0.0);
  for (int i = 0; i < n; ++i) {
    const int first = std::clamp(i - window / 2, 0, n - window);
    const auto around = values.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(window));
    for (const auto& b : basis) {
      smooth[static_cast<std::size_t>(i)] +=
          std::inner_product(b.begin(), b.end(), around.begin(), 0.0) * b[static_cast<std::size_t>(i - first)];
    }
  }
  return smooth;
}

}  // namespace mpm
