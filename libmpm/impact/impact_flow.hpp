#pragma once
/// Properties of the incoming flow that the measurements need.

#include <optional>

namespace mpm {

/// Input of steady criteria, force peaks and predictions.
struct ImpactFlow {
  double velocity = 0.0;                     ///< v, m/s
  double gravity = 9.81;                     ///< g, m/s^2
  double arrival = 0.0;                      ///< s; the conveyor's front is at the face at t = 0
  std::optional<double> effective_friction;  ///< M'; empty for laws without M': no prediction
};

}  // namespace mpm
