#pragma once
/// One material point led along a path of deformation: the law alone, without particles or grid (`mpm point`).

#include <array>
#include <string_view>
#include <variant>
#include <vector>

#include "mpm/case.hpp"
#include "mpm/tensor.hpp"
#include "mpm/types.hpp"

namespace mpm {

/// Increment of Hencky strain d_eps = d_eps_v/3 I + d_eps_q diag(1/2, 1/2, -1): eps_v expansion positive, eps_q axial (z) shortening
/// positive.
struct StrainSegment {
  double d_eps_v = 0.0;
  double d_eps_q = 0.0;
};

/// Steady velocity gradient L (1/s) for `time` seconds; spins and shears allowed.
struct VelocityGradientSegment {
  Mat3 velocity_gradient = Mat3::Zero();
  double time = 1.0;  ///< s, above 0
};

/// Drained triaxial test: the axial Hencky strain changes by d_eps_axial (shortening negative) while the radial Kirchhoff stress stays
/// at -radial_stress. A radial stress that differs from it at the start is brought to it within the first step.
struct TriaxialSegment {
  double radial_stress = 0.0;  ///< Pa, compression positive
  double d_eps_axial = 0.0;
};

using PathSegment = std::variant<StrainSegment, VelocityGradientSegment, TriaxialSegment>;

/// The path starts at the law's stress-free reference state.
struct PathSpec {
  MaterialSpec material;
  int steps_per_segment = 160;
  std::vector<PathSegment> segments;
};

/// State after a step; Kirchhoff stress, p compression positive.
struct PathRow {
  int step;                          ///< counted over all segments; row 0 is the initial state
  double eps_v;                      ///< tr eps, eps = 1/2 log(F F^T) from the start of the path
  double eps_q;                      ///< sqrt(2/3) |dev eps|, never negative
  double p;                          ///< -tr(tau)/3, Pa
  double q;                          ///< sqrt(3/2) |dev tau|, Pa
  double eps_v_plastic;              ///< -X: starts at -X_0; 0 for a law without plasticity
  double preconsolidation_pressure;  ///< p_c, Pa; 0 for a law without plasticity
  double yield;                      ///< y, Pa^2; 0 for a law without plasticity
  Sym3<double> stress{};             ///< tau, Pa, tension positive; no column of the CSV
};

/// Column names of PathRow, in order, as in the CSV of `mpm point`.
inline constexpr std::array<std::string_view, 8> path_columns{
    "step", "eps_v", "eps_q", "p_pa", "q_pa", "eps_v_plastic", "preconsolidation_pressure_pa", "yield_pa2"};

/// Leads the point along the path; row 0 is the initial state, then one row every `stride` steps, which must divide steps_per_segment.
/// Each step applies F_inc = exp(d_eps) or exp(L dt), that is dl = F_inc - I: the deformation at a segment's end does not depend on the
/// number of steps. ConfigError for a senseless path or material; UnstableError where a radial stress cannot be held or the state is not
/// finite.
std::vector<PathRow> follow_path(const PathSpec& path, int stride = 1);

}  // namespace mpm
