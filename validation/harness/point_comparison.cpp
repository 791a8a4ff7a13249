#include "validation/harness/point_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm/error.hpp"

namespace mpm::validation {

MaterialSpec cam_clay_spec(double slope, double beta, double xi, double pc0, double young, double poisson) {
  MaterialSpec spec;
  spec.model = "cohesive_cam_clay";
  spec.density = 300.0;
  spec.young_modulus = young;
  spec.poisson_ratio = poisson;
  spec.critical_state_slope = slope;
  spec.cohesion_beta = beta;
  spec.hardening_xi = xi;
  spec.preconsolidation_pressure = pc0;
  return spec;
}

CamClay reference_model(const MaterialSpec& s) {
  return CamClay::from_young(s.young_modulus, s.poisson_ratio, s.critical_state_slope, s.cohesion_beta, s.hardening_xi,
                             s.preconsolidation_pressure);
}

PathSpec library_path(const MaterialSpec& spec, const std::vector<ReferenceSegment>& segments, int steps_per_segment) {
  PathSpec path{spec, steps_per_segment, {}};
  for (const ReferenceSegment& s : segments) switch (s.control) {
      case ReferenceSegment::Control::strain: path.segments.emplace_back(StrainSegment{s.d_eps_v, s.d_eps_q}); break;
      case ReferenceSegment::Control::drained_triaxial: path.segments.emplace_back(TriaxialSegment{s.radial_stress, s.d_eps_axial}); break;
      case ReferenceSegment::Control::velocity_gradient: path.segments.emplace_back(VelocityGradientSegment{s.gradient, 1.0}); break;
    }
  return path;
}

double PathComparison::tail_order() const {
  const std::size_t n = error.size();
  if (n < 2 || error[n - 1] < 1e-10) return std::numeric_limits<double>::quiet_NaN();
  return std::log(error[n - 2] / error[n - 1]) / std::log(size[n - 2] / size[n - 1]);
}

bool PathComparison::exact() const {
  return std::all_of(error.begin(), error.end(), [](double e) { return e < 1e-10; });
}

PathComparison compare_path(const MaterialSpec& spec, const std::vector<ReferenceSegment>& segments, const std::vector<int>& steps,
                            bool general) {
  PathComparison c;
  const int finest = steps.back();
  ReferenceOptions options;
  options.samples_per_segment = static_cast<std::size_t>(finest);
  const CamClay model = reference_model(spec);
  c.reference = general ? general_reference(model, segments, options) : coaxial_reference(model, segments, options);
  for (const ReferencePoint& r : c.reference.points) c.scale = std::max({c.scale, r.preconsolidation, r.q});
  for (const int n : steps) {
    if (finest % n != 0) throw ConfigError(fmt::format("compare_path: {} steps do not divide {}", n, finest));
    const std::vector<PathRow> rows = follow_path(library_path(spec, segments, n));
    const auto stride = static_cast<std::size_t>(finest / n);
    double worst = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const ReferencePoint& r = c.reference.points.at(i * stride);
      for (const double e : {rows[i].p - r.p, rows[i].q - r.q, rows[i].preconsolidation_pressure - r.preconsolidation})
        if (!(std::abs(e) <= worst)) worst = std::isnan(worst) ? worst : std::abs(e);
    }
    c.size.push_back(1.0 / n);
    c.error.push_back(worst / c.scale);
    if (n == finest) c.finest = rows;
  }
  return c;
}

}  // namespace mpm::validation
