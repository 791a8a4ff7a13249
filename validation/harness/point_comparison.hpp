#pragma once
/// The library's return map against the SUNDIALS reference on one path, at several step counts.

#include <string>
#include <vector>

#include "libmpm/driver/point_path.hpp"
#include "validation/harness/ode_reference.hpp"

namespace mpm::validation {

/// `base` with another M, beta and xi.
mpm::CamClay::Parameters with_plasticity(mpm::CamClay::Parameters base, double slope, double beta, double xi);
/// The parameters of a cohesive_cam_clay in the reference's symbols.
CamClay reference_model(const mpm::CamClay::Parameters& spec);

/// The library's path for the reference's segments.
PathSpec library_path(const MaterialParameters& spec, const std::vector<ReferenceSegment>& segments, int steps_per_segment);
/// The reference's segments for a path read from a file.
std::vector<ReferenceSegment> reference_segments(const PathSpec& path);

/// How a path is compared.
struct ComparisonOptions {
  bool general = false;  ///< the b_e form of the reference (needed for velocity gradients); the full stress tensor is compared then too
  int samples = 640;     ///< points per segment at which the reference is compared with all step counts that have a step end there
  int coarsest = 160;    ///< steps per segment; doubled from here
  int finest = 20480;    ///< more, by powers of two, on paths that come close to a snap-back: see below
};

/// Backward Euler against the reference in the maximum norm along the path: largest |p - p_ref|, |q - q_ref|, |p_c - p_c,ref| and, on
/// general paths, |tau_ij - tau_ij,ref| over all sampled step ends, over the largest p_c (|p| for a law without p_c) or q of the
/// reference path.
///
/// The finest step follows from the reference alone. Close to a fold of the solution (a snap-back), where D = m (K y_p^2 + 3 G y_q^2) with
/// a small margin m, one step changes D by a fraction of m that must itself be small: its number grows like 1/m^2. So options.finest holds
/// for m >= 0.1 and is raised by (0.1/m)^2, at most 64 times, below; not where the point snaps back at the onset of yield (m <= 0), which
/// no step resolves.
struct PathComparison {
  ReferencePath reference;
  std::vector<PathRow> finest;  ///< the library's rows with the most steps, at the reference's points
  std::vector<int> steps;       ///< per segment, coarse first
  std::vector<double> error;
  double scale = 0.0;  ///< Pa
  bool jumps = false;  ///< the reference snaps back

  /// Between the two finest runs; NaN where the error is round-off already.
  [[nodiscard]] double tail_order() const;
  /// Over the last two doublings: the mean order behind a jump, whose instant moves by whole steps.
  [[nodiscard]] double mean_order() const;
  /// Every error is below `tolerance`.
  [[nodiscard]] bool exact(double tolerance = 1e-12) const;
};

/// @throws ConfigError where samples and step counts have no common points
PathComparison compare_path(const MaterialParameters& spec, const std::vector<ReferenceSegment>& segments, ReferencePath reference,
                            const ComparisonOptions& options);
/// The same, with the reference of Cam-Clay.
PathComparison compare_path(const mpm::CamClay::Parameters& spec, const std::vector<ReferenceSegment>& segments,
                            const ComparisonOptions& options = {});

/// Largest error along a path on which q = 0 or M = 0, against exact::isotropic: of p, q (zero) and p_c over the largest p_c, for the
/// library with each of `steps`. The volume change within a step must be monotone.
double isotropic_error(const mpm::CamClay::Parameters& spec, const std::vector<ReferenceSegment>& segments, const std::vector<int>& steps);

/// Largest difference in p, q, p_c between the CVODE path and the IDA form, over the largest p_c or q of the path, in all plastic stretches
/// of at least three points within strain-controlled segments. The path must not snap back.
struct FormDifference {
  double largest = 0.0;
  int points = 0;
};
FormDifference compare_forms(const CamClay& model, const std::vector<ReferenceSegment>& segments, const ReferencePath& path);

}  // namespace mpm::validation
