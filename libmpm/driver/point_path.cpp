#include "libmpm/driver/point_path.hpp"

#include <fmt/format.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

#include "libmpm/base/error.hpp"
#include "libmpm/base/parameter.hpp"
#include "libmpm/driver/estimate.hpp"

namespace mpm {

namespace {

Matrix3<double> to_matrix3(const Mat3& a) {
  Matrix3<double> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.m[i][j] = a(i, j);
  return r;
}

/// exp(diag(x, y, z)) - I
Mat3 stretch_increment(double x, double y, double z) { return Vec3(std::expm1(x), std::expm1(y), std::expm1(z)).asDiagonal(); }

template <Material L>
class Point {
 public:
  explicit Point(const L& law) : law_(law) { state_.internal = law.initial_internal(); }

  /// @param dl  F_inc - I; @param dt  s
  void deform(const Mat3& dl, double dt) {
    law_.update_stress(state_, to_matrix3(dl), dt);
    deformation_ += dl * deformation_;
    if (!std::isfinite(trace(state_.stress) + norm2(state_.stress) + state_.internal))
      throw UnstableError("point path: the state is not finite; the increments are too large");
  }

  /// Radial Kirchhoff stress after an axial and a radial Hencky increment, without changing the state.
  [[nodiscard]] double radial_stress(double axial, double radial) const {
    MaterialState<double> trial = state_;
    law_.update_stress(trial, to_matrix3(stretch_increment(radial, radial, axial)), 1.0);
    return trial.stress.xx;
  }

  [[nodiscard]] PathRow row(int step) const {
    const Mat3 b = deformation_ * deformation_.transpose() - Mat3::Identity();
    const HenckyStrain<double> eps = half_log_identity_plus<double>({b(0, 0), b(1, 1), b(2, 2), b(0, 1), b(0, 2), b(1, 2)});
    PathRow r{step, eps.volumetric, std::sqrt(2.0 / 3.0 * norm2(eps.deviator)), -trace(state_.stress) / 3.0, 0.0, 0.0, 0.0, 0.0};
    r.q = std::sqrt(1.5 * norm2(deviator(state_.stress)));
    r.stress = state_.stress;
    if constexpr (requires { law_.preconsolidation_pressure(0.0); }) {
      r.eps_v_plastic = -state_.internal;
      r.preconsolidation_pressure = law_.preconsolidation_pressure(state_.internal);
    }
    if constexpr (requires { law_.plastic_volume_strain(state_); }) r.eps_v_plastic = law_.plastic_volume_strain(state_);
    if constexpr (requires { law_.yield_function(state_); }) r.yield = law_.yield_function(state_);
    return r;
  }

 private:
  const L& law_;
  MaterialState<double> state_{};
  Mat3 deformation_ = Mat3::Identity();
};

/// The radial Hencky increment that brings the radial stress to -target: a bracket grown from the previous increment, then TOMS 748 down
/// to round-off.
template <Material L>
double hold_radial_stress(const Point<L>& point, double axial, double target, double guess) {
  constexpr double widest = 0.5;  // Hencky strain in one step; a path with larger steps has no meaning
  const auto excess = [&](double radial) { return point.radial_stress(axial, radial) + target; };
  double low = guess, high = guess, f_low = excess(guess), f_high = f_low;
  for (double grow = max(0.1 * std::fabs(axial), 1e-9); !(f_low <= 0.0 && f_high >= 0.0); grow *= 2.0) {
    if (!(grow < widest))
      throw UnstableError(fmt::format(
          "point path: a radial stress of {} Pa cannot be held at an axial increment of {}; use more steps or less strain", target, axial));
    if (f_low > 0.0) low = guess - grow, f_low = excess(low);
    if (f_high < 0.0) high = guess + grow, f_high = excess(high);
  }
  // Round-off of the stress: a few ulp of the moduli times the strains, seen here as a relative 1e-13 of the target.
  const double tolerance = 1e-13 * max(std::fabs(target), 1.0);
  if (std::fabs(f_low) <= tolerance) return low;
  if (std::fabs(f_high) <= tolerance) return high;
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      excess, low, high, f_low, f_high, boost::math::tools::eps_tolerance<double>(std::numeric_limits<double>::digits), iterations);
  const double best = std::fabs(excess(bracket.first)) < std::fabs(excess(bracket.second)) ? bracket.first : bracket.second;
  if (std::fabs(excess(best)) > 1e-9 * max(std::fabs(target), 1.0))
    throw UnstableError(fmt::format("point path: the stress jumps past a radial stress of {} Pa (snap-back); it cannot be held", target));
  return best;
}

void check(const PathSpec& path, int stride) {
  if (path.steps_per_segment < 1)
    throw ConfigError(fmt::format("[path] steps_per_segment = {}: at least 1 is needed", path.steps_per_segment));
  if (stride < 1 || path.steps_per_segment % stride != 0)
    throw ConfigError(fmt::format("point path: a row every {} steps does not divide {} steps per segment", stride, path.steps_per_segment));
  if (path.segments.empty()) throw ConfigError("[path] segments: at least one is needed");
  const double steps = static_cast<double>(path.steps_per_segment) * static_cast<double>(path.segments.size());
  constexpr double most_path_steps = 1e9;  // counted by an int
  const double bytes = steps / stride * sizeof(PathRow), limit = physical_memory_bytes();
  if (steps > most_path_steps || bytes > limit) {
    throw ConfigError(
        fmt::format("[path] {} segments of steps_per_segment = {} are {:.4g} steps and {:.3g} GB of rows; at most {:.4g} steps and "
                    "this machine's {:.3g} GB are possible, take fewer steps",
                    path.segments.size(), path.steps_per_segment, steps, bytes / 1e9, most_path_steps, limit / 1e9));
  }
  const auto finite = [](const auto& segment) {
    using S = std::decay_t<decltype(segment)>;
    if constexpr (std::same_as<S, StrainSegment>) return std::isfinite(segment.d_eps_v) && std::isfinite(segment.d_eps_q);
    if constexpr (std::same_as<S, VelocityGradientSegment>)
      return segment.velocity_gradient.allFinite() && std::isfinite(segment.time) && segment.time > 0.0;
    if constexpr (std::same_as<S, TriaxialSegment>) return std::isfinite(segment.radial_stress) && std::isfinite(segment.d_eps_axial);
  };
  for (std::size_t i = 0; i < path.segments.size(); ++i)
    if (!std::visit(finite, path.segments[i]))
      throw ConfigError(fmt::format("[path] segments[{}]: finite values are needed, and time_s above 0", i));
}

template <Material L>
std::vector<PathRow> follow(const L& law, const PathSpec& path, int stride) {
  const int n = path.steps_per_segment;
  Point<L> point(law);
  std::vector<PathRow> rows{point.row(0)};
  int step = 0;
  const auto record = [&] {
    if (++step % stride == 0) rows.push_back(point.row(step));
  };

  const auto lead = [&](const auto& segment) {
    using S = std::decay_t<decltype(segment)>;
    if constexpr (std::same_as<S, StrainSegment>) {
      const double mean = segment.d_eps_v / 3.0 / n, shear = segment.d_eps_q / n;
      const Mat3 dl = stretch_increment(mean + 0.5 * shear, mean + 0.5 * shear, mean - shear);
      for (int i = 0; i < n; ++i) point.deform(dl, 1.0), record();
    } else if constexpr (std::same_as<S, VelocityGradientSegment>) {
      const double dt = segment.time / n;
      const Mat3 dl = exp_minus_identity(Mat3(segment.velocity_gradient * dt));
      for (int i = 0; i < n; ++i) point.deform(dl, dt), record();
    } else {
      const double axial = segment.d_eps_axial / n;
      double radial = 0.0;
      for (int i = 0; i < n; ++i) {
        radial = hold_radial_stress(point, axial, segment.radial_stress, radial);
        point.deform(stretch_increment(radial, radial, axial), 1.0), record();
      }
    }
  };
  for (const PathSegment& segment : path.segments) std::visit(lead, segment);
  return rows;
}

}  // namespace

void SegmentParameters::check(ParameterReport& report) const {
  const auto has = [&](const char* name) { return report.given(name); };
  const bool strain = has("d_eps_v") || has("d_eps_q");
  const bool gradient = has("velocity_gradient") || has("time_s");
  const bool triaxial = has("radial_stress_pa") || has("d_eps_axial");
  const bool whole = strain || (has("velocity_gradient") && has("time_s")) || (has("radial_stress_pa") && has("d_eps_axial"));
  if (int{strain} + int{gradient} + int{triaxial} == 1 && whole) return;
  report.problem(
      "",
      "is not one of {d_eps_v, d_eps_q}, {velocity_gradient, time_s}, {radial_stress_pa, d_eps_axial}; give exactly one of these "
      "groups");
}

PathSegment SegmentParameters::segment() const {
  if (velocity_gradient) return VelocityGradientSegment{*velocity_gradient, *time};
  if (radial_stress) return TriaxialSegment{*radial_stress, *d_eps_axial};
  return StrainSegment{d_eps_v.value_or(0.0), d_eps_q.value_or(0.0)};
}

std::vector<PathRow> follow_path(const PathSpec& path, int stride) {
  check(path, stride);
  return std::visit([&](const auto& law) { return follow(law, path, stride); }, make_material(path.material));
}

}  // namespace mpm
