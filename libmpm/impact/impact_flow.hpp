#pragma once
/// The flow that hits an obstacle, as the measurements need it.

#include <optional>

namespace mpm {

/// What steady criteria, force peaks and predictions are computed from.
struct ImpactFlow {
  double velocity = 0.0;                     ///< v, m/s
  double gravity = 9.81;                     ///< g, m/s^2
  double arrival = 0.0;                      ///< s; the conveyor's front is at the face at t = 0
  std::optional<double> effective_friction;  ///< M'; empty for laws that have none: no prediction
};

}  // namespace mpm
