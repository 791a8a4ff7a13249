#pragma once
/// The library's return map against the SUNDIALS reference on one path, at several step counts.

#include <string>
#include <vector>

#include "mpm/point_path.hpp"
#include "validation/harness/ode_reference.hpp"

namespace mpm::validation {

/// The material of a reference path as the library reads it (E = 1 MPa, nu = 0.1, rho_0 = 300 kg/m^3 unless given).
MaterialSpec cam_clay_spec(double slope, double beta, double xi, double pc0 = 1e4, double young = 1e6, double poisson = 0.1);
CamClay reference_model(const MaterialSpec& spec);

/// The library's path for the reference's segments.
PathSpec library_path(const MaterialSpec& spec, const std::vector<ReferenceSegment>& segments, int steps_per_segment);

/// Backward Euler against the reference in the maximum norm along the path: largest |p - p_ref|, |q - q_ref|, |p_c - p_c,ref| over all
/// step ends, over the largest p_c or q of the reference path.
struct PathComparison {
  ReferencePath reference;      ///< sampled as the finest run
  std::vector<PathRow> finest;  ///< the library's rows with the most steps
  std::vector<double> size;     ///< 1 / steps per segment, coarse first
  std::vector<double> error;
  double scale = 0.0;                       ///< Pa
  [[nodiscard]] double tail_order() const;  ///< between the two finest runs; NaN where the error is round-off already
  [[nodiscard]] bool exact() const;         ///< the error is below 1e-10 at every step count: the map has no step error on this path
};

/// @param general  use the b_e form of the reference (needed for velocity gradients)
/// @param steps    steps per segment, rising; each divides the last
PathComparison compare_path(const MaterialSpec& spec, const std::vector<ReferenceSegment>& segments, const std::vector<int>& steps,
                            bool general = false);

}  // namespace mpm::validation
