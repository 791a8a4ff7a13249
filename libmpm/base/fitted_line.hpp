#pragma once
/// Least-squares lines.

#include <vector>

namespace mpm {

/// The line y = at_zero + slope x.
struct Line {
  double slope;    ///< dy/dx
  double at_zero;  ///< y at x = 0
};

/// The least-squares line through the points (x, y). @param x  as many as y, at least two of them different
inline Line fitted_line(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, sy / n - slope * sx / n};
}

}  // namespace mpm
