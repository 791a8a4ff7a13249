#include "validation/harness/comparison.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "libmpm/base/error.hpp"

namespace mpm::validation {
namespace {

/// SI prefixes that units of checks have, and their factors.
double prefix_factor(const std::string& prefix) {
  if (prefix.empty()) return 1.0;
  if (prefix == "k") return 1e3;
  if (prefix == "M") return 1e6;
  if (prefix == "m") return 1e-3;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

QuantityText text_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::force: return {"force", "N"};
    case Quantity::pressure: return {"pressure", "Pa"};
    case Quantity::run_up: return {"run-up", "m"};
    case Quantity::pressure_height: return {"pressure height", "m"};
    case Quantity::run_out: return {"run-out", "m"};
    case Quantity::depth: return {"depth", "m"};
    case Quantity::displacement: return {"displacement", "m"};
    case Quantity::speed: return {"speed", "m/s"};
    case Quantity::angle: return {"angle", "°"};
    case Quantity::time: return {"time", "s"};
    case Quantity::frequency: return {"frequency", "Hz"};
    case Quantity::density: return {"density", "kg/m³"};
  }
  return {"unknown", ""};
}

double Comparison::ratio() const {
  const double r = predicted / reference;
  return r > 0.0 && std::isfinite(r) ? r : std::numeric_limits<double>::quiet_NaN();
}

Comparison make_comparison(Quantity quantity, double predicted, double reference, const std::string& unit, double reference_uncertainty) {
  const QuantityText text = text_of(quantity);
  const bool ends_with_unit = unit.size() >= text.unit.size() && unit.ends_with(text.unit);
  const double factor =
      ends_with_unit ? prefix_factor(unit.substr(0, unit.size() - text.unit.size())) : std::numeric_limits<double>::quiet_NaN();
  if (std::isnan(factor)) {
    throw ConfigError(
        fmt::format("summary: a {} is in '{}', not in '{}' with a prefix; give the unit's value in it", text.name, unit, text.unit));
  }
  if (!(reference_uncertainty >= 0.0) || !std::isfinite(reference_uncertainty))
    throw ConfigError(fmt::format("summary: the uncertainty of a reference is {}: must be zero or positive", reference_uncertainty));
  return {quantity, factor * predicted, factor * reference, reference_uncertainty};
}

}  // namespace mpm::validation
