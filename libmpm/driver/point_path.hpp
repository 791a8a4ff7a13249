#pragma once
/// One material point on a path of deformation: the law alone, without particles or grid (`mpm point`).

#include <array>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "libmpm/base/tensor.hpp"
#include "libmpm/base/types.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {

/// Increment of Hencky strain d_eps = d_eps_v/3 I + d_eps_q diag(1/2, 1/2, -1): eps_v expansion positive, eps_q axial (z) shortening
/// positive.
struct StrainSegment {
  double d_eps_v = 0.0;  ///< Hencky, expansion positive
  double d_eps_q = 0.0;  ///< Hencky, axial shortening positive
};

/// Steady velocity gradient L (1/s) for `time` seconds; spins and shears allowed.
struct VelocityGradientSegment {
  Mat3 velocity_gradient = Mat3::Zero();  ///< L, 1/s
  double time = 1.0;                      ///< s, above 0
};

/// Drained triaxial test: the axial Hencky strain changes by d_eps_axial (shortening negative) while the radial Kirchhoff stress stays
/// at -radial_stress. A radial stress that differs from it at the start is brought to it within the first step.
struct TriaxialSegment {
  double radial_stress = 0.0;  ///< Pa, compression positive
  double d_eps_axial = 0.0;    ///< Hencky, extension positive
};

using PathSegment = std::variant<StrainSegment, VelocityGradientSegment, TriaxialSegment>;  ///< one of three kinds of test

/// [path]
struct PathSteps {
  int per_segment = 160;  ///< equal steps of each segment

  /// The keys of [path] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("steps_per_segment", &PathSteps::per_segment).range(1.0, 1e8).text("Equal steps into which each segment is cut");
  }
};

/// One entry of path.segments; which of the three kinds it is follows from the keys given.
struct SegmentParameters {
  std::optional<double> d_eps_v, d_eps_q;  ///< of a StrainSegment
  std::optional<Mat3> velocity_gradient;   ///< 1/s
  std::optional<double> time;              ///< s
  std::optional<double> radial_stress;     ///< Pa
  std::optional<double> d_eps_axial;       ///< of a TriaxialSegment

  /// The keys of [[path.segments]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    constexpr double largest_strain = 2.0;  // Hencky: 7.4 times the length; larger strains are beyond the range of the laws
    const char* const other_kind = "the segment is given by other keys";
    table.add("d_eps_v", &SegmentParameters::d_eps_v)
        .range(-largest_strain, largest_strain)
        .left_out(other_kind)
        .text("Increment of volumetric Hencky strain, expansion positive (with d_eps_q; one of the two left out is 0)");
    table.add("d_eps_q", &SegmentParameters::d_eps_q)
        .range(-largest_strain, largest_strain)
        .left_out(other_kind)
        .text("Increment of deviatoric Hencky strain d_eps_q diag(1/2, 1/2, -1): axial shortening along z positive");
    table.add("velocity_gradient", &SegmentParameters::velocity_gradient)
        .unit("1/s")
        .range(-1e6, 1e6)
        .left_out(other_kind)
        .text("Constant velocity gradient l_ij = dv_i/dx_j by rows, over time_s");
    table.add("time_s", &SegmentParameters::time)
        .unit("s")
        .positive(1e6)
        .left_out(other_kind)
        .text("Duration of a segment given by velocity_gradient");
    table.add("radial_stress_pa", &SegmentParameters::radial_stress)
        .unit("Pa")
        .range(-1e9, 1e9)
        .left_out(other_kind)
        .text("Kirchhoff stress held in x and y, compression positive (drained triaxial test, with d_eps_axial)");
    table.add("d_eps_axial", &SegmentParameters::d_eps_axial)
        .range(-largest_strain, largest_strain)
        .left_out(other_kind)
        .text("Increment of Hencky strain along z, extension positive");
  }
  /// Exactly one of the three groups of keys must be given, and completely.
  void check(ParameterReport& report) const;
  [[nodiscard]] PathSegment segment() const;  ///< after check()
};

/// The path starts at the law's stress-free reference state.
struct PathSpec {
  MaterialParameters material;        ///< the law
  int steps_per_segment = 160;        ///< equal steps of each segment
  std::vector<PathSegment> segments;  ///< one after the other
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

/// Computes the path; row 0 is the initial state, then one row every `stride` steps, which must divide steps_per_segment.
/// Each step applies F_inc = exp(d_eps) or exp(L dt), that is dl = F_inc - I: the deformation at a segment's end does not depend on the
/// number of steps. ConfigError for an invalid path or material; UnstableError if a radial stress cannot be held or the state is not
/// finite.
std::vector<PathRow> follow_path(const PathSpec& path, int stride = 1);

}  // namespace mpm
