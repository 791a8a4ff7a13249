#pragma once
/// Discrete error norms. A NaN in the data is a NaN in the norm: no comparison hides it.

#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "libmpm/base/error.hpp"

namespace mpm::validation {

/// Errors of a field against its reference, in the field's own unit.
struct Norms {
  double l1;   ///< sum w |a - b| / sum w
  double l2;   ///< sqrt(sum w (a - b)^2 / sum w)
  double max;  ///< max |a - b|
};

/// @param value, reference  the same number of samples, at least one
/// @param weight            volumes, or empty for equal weights; each > 0
/// @throws ConfigError      where the lengths differ or nothing is given
inline Norms error_norms(std::span<const double> value, std::span<const double> reference, std::span<const double> weight = {}) {
  if (value.empty() || value.size() != reference.size() || (!weight.empty() && weight.size() != value.size()))
    throw ConfigError("error_norms: value, reference and weight need one common, non-zero length");
  Norms n{0.0, 0.0, 0.0};
  double total = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const double e = std::abs(value[i] - reference[i]);
    const double w = weight.empty() ? 1.0 : weight[i];
    total += w;
    n.l1 += w * e;
    n.l2 += w * e * e;
    if (!(e <= n.max)) n.max = std::isnan(n.max) ? n.max : e;  // written so that a NaN is taken and kept
  }
  n.l1 /= total;
  n.l2 = std::sqrt(n.l2 / total);
  return n;
}

/// The larger and the smaller of two numbers. A NaN of either is taken, which std::max and std::min drop or keep by their order.
/// @{
inline double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }
inline double smaller(double a, double b) { return a <= b || std::isnan(a) ? a : b; }
/// @}

/// |value - reference| / |reference|; for a zero reference infinity, or 0 where both are zero.
inline double relative_error(double value, double reference) {
  if (reference == 0.0) return value == 0.0 ? 0.0 : std::abs(value) * std::numeric_limits<double>::infinity();
  return std::abs(value - reference) / std::abs(reference);
}

/// The largest of some values, its name, and their number. A NaN is taken and kept.
struct Extreme {
  double value = -std::numeric_limits<double>::infinity();
  std::string name;
  int count = 0;
  void add(double v, const std::string& who) {
    ++count;
    if (v <= value || std::isnan(value)) return;
    value = v;
    name = who;
  }
};

}  // namespace mpm::validation
