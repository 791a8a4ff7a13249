#include "validation/harness/point_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "libmpm/base/error.hpp"
#include "validation/harness/norms.hpp"

namespace mpm::validation {
namespace {

constexpr double round_off = 1e-12;

double difference(const PathRow& row, const ReferencePoint& r, bool tensor) {
  double e = 0.0;
  for (const double d : {row.p - r.p, row.q - r.q, row.preconsolidation_pressure - r.preconsolidation}) e = larger(e, std::abs(d));
  if (tensor) {
    const Sym3<double>& a = row.stress;
    const Mat3& b = r.stress;
    for (const double d : {a.xx - b(0, 0), a.yy - b(1, 1), a.zz - b(2, 2), a.xy - b(0, 1), a.xz - b(0, 2), a.yz - b(1, 2)})
      e = larger(e, std::abs(d));
  }
  return e;
}

/// eps_v that the segments prescribe at the row: free of the round-off that 1/2 log det(F F^T) gathers over the steps. Stress-controlled
/// segments prescribe none; there the row's own is taken.
double prescribed_volume(const std::vector<ReferenceSegment>& segments, const PathRow& row, int steps_per_segment) {
  double sum = 0.0, passed = static_cast<double>(row.step) / steps_per_segment;
  for (const ReferenceSegment& s : segments) {
    if (passed <= 0.0) break;
    if (s.control == ReferenceSegment::Control::drained_triaxial) return row.eps_v;
    sum += std::min(passed, 1.0) * (s.control == ReferenceSegment::Control::strain ? s.d_eps_v : s.gradient.trace());
    passed -= 1.0;
  }
  return sum;
}

/// By how much the number of steps is raised near a snap-back; see PathComparison.
int refinement(double margin) {
  if (margin <= 0.0 || margin >= 0.1) return 1;
  return std::min(64, static_cast<int>(std::exp2(std::ceil(2.0 * std::log2(0.1 / margin)))));
}

}  // namespace

mpm::CamClay::Parameters with_plasticity(mpm::CamClay::Parameters base, double slope, double beta, double xi) {
  base.critical_state_slope = slope;
  base.cohesion_beta = beta;
  base.hardening_xi = xi;
  return base;
}

CamClay reference_model(const mpm::CamClay::Parameters& s) {
  return CamClay::from_young(s.young_modulus, s.poisson_ratio, s.critical_state_slope, s.cohesion_beta, s.hardening_xi,
                             s.preconsolidation_pressure);
}

PathSpec library_path(const MaterialParameters& spec, const std::vector<ReferenceSegment>& segments, int steps_per_segment) {
  PathSpec path{spec, steps_per_segment, {}};
  for (const ReferenceSegment& s : segments) switch (s.control) {
      case ReferenceSegment::Control::strain: path.segments.emplace_back(StrainSegment{s.d_eps_v, s.d_eps_q}); break;
      case ReferenceSegment::Control::drained_triaxial: path.segments.emplace_back(TriaxialSegment{s.radial_stress, s.d_eps_axial}); break;
      case ReferenceSegment::Control::velocity_gradient: path.segments.emplace_back(VelocityGradientSegment{s.gradient, 1.0}); break;
    }
  return path;
}

std::vector<ReferenceSegment> reference_segments(const PathSpec& path) {
  std::vector<ReferenceSegment> segments;
  for (const PathSegment& segment : path.segments) {
    if (const auto* strain = std::get_if<StrainSegment>(&segment))
      segments.push_back(ReferenceSegment::strain_increment(strain->d_eps_v, strain->d_eps_q));
    else if (const auto* drained = std::get_if<TriaxialSegment>(&segment))
      segments.push_back(ReferenceSegment::drained(drained->radial_stress, drained->d_eps_axial));
    else if (const auto* general = std::get_if<VelocityGradientSegment>(&segment))
      segments.push_back(ReferenceSegment::general(general->velocity_gradient * general->time));
  }
  return segments;
}

double PathComparison::tail_order() const {
  const std::size_t n = error.size();
  if (n < 2 || error[n - 1] < round_off) return std::numeric_limits<double>::quiet_NaN();
  return std::log2(error[n - 2] / error[n - 1]);
}

double PathComparison::mean_order() const {
  const std::size_t n = error.size();
  if (n < 3 || error[n - 1] < round_off) return std::numeric_limits<double>::quiet_NaN();
  return 0.5 * std::log2(error[n - 3] / error[n - 1]);
}

bool PathComparison::exact(double tolerance) const {
  return std::all_of(error.begin(), error.end(), [&](double e) { return e < tolerance; });
}

PathComparison compare_path(const MaterialParameters& spec, const std::vector<ReferenceSegment>& segments, ReferencePath reference,
                            const ComparisonOptions& options) {
  PathComparison c;
  c.reference = std::move(reference);
  for (const ReferencePoint& r : c.reference.points) {
    c.scale = std::max({c.scale, r.preconsolidation, r.q});
    if (r.preconsolidation == 0.0) c.scale = larger(c.scale, std::abs(r.p));
  }
  c.jumps = std::any_of(c.reference.events.begin(), c.reference.events.end(),
                        [](const EventRecord& e) { return e.event == PathEvent::snap_back; });

  const int finest = options.finest * refinement(c.reference.margin);
  for (int n = options.coarsest; n <= finest; n *= 2) {
    const int common = std::gcd(n, options.samples);  // step ends per segment at which the reference is known
    std::vector<PathRow> rows = follow_path(library_path(spec, segments, n), n / common);
    const auto stride = static_cast<std::size_t>(options.samples / common);
    double worst = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i)
      worst = larger(worst, difference(rows[i], c.reference.points.at(i * stride), options.general));
    c.steps.push_back(n);
    c.error.push_back(worst / c.scale);
    c.finest = std::move(rows);
  }
  if (c.finest.size() != c.reference.points.size())
    throw ConfigError(fmt::format("compare_path: {} samples do not divide {} steps", options.samples, finest));
  return c;
}

PathComparison compare_path(const mpm::CamClay::Parameters& spec, const std::vector<ReferenceSegment>& segments,
                            const ComparisonOptions& options) {
  ReferenceOptions reference;
  reference.samples_per_segment = static_cast<std::size_t>(options.samples);
  const CamClay model = reference_model(spec);
  return compare_path(spec, segments,
                      options.general ? general_reference(model, segments, reference) : coaxial_reference(model, segments, reference),
                      options);
}

double isotropic_error(const mpm::CamClay::Parameters& spec, const std::vector<ReferenceSegment>& segments, const std::vector<int>& steps) {
  const CamClay model = reference_model(spec);
  double worst = 0.0;
  for (const int n : steps) {
    double internal = model.initial_internal(), scale = 0.0, error = 0.0;
    for (const PathRow& row : follow_path(library_path(spec, segments, n))) {
      const double eps_v = prescribed_volume(segments, row, n);
      internal = exact::isotropic(model, -eps_v, internal);
      const double pc = model.preconsolidation(internal);
      scale = larger(scale, pc);
      for (const double d :
           {row.p - model.bulk_modulus * (model.initial_internal() - eps_v - internal), row.q, row.preconsolidation_pressure - pc})
        error = larger(error, std::abs(d));
    }
    worst = larger(worst, error / scale);
  }
  return worst;
}

FormDifference compare_forms(const CamClay& model, const std::vector<ReferenceSegment>& segments, const ReferencePath& path) {
  const std::size_t n = (path.points.size() - 1) / segments.size();
  FormDifference result;
  double scale = 0.0;
  for (const ReferencePoint& r : path.points) scale = std::max({scale, r.preconsolidation, r.q});
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (segments[i].control != ReferenceSegment::Control::strain) continue;
    const std::size_t end = (i + 1) * n;
    std::size_t first = i * n;
    // The state at a segment's start carries the flag of the segment before: it may unload from here.
    if (!path.points[first + 1].plastic) ++first;
    while (first < end) {
      while (first < end && !path.points[first].plastic) ++first;
      std::size_t last = first;
      while (last < end && path.points[last + 1].plastic) ++last;
      const std::size_t samples = last - first;
      if (samples >= 2) {
        const double share = static_cast<double>(samples) / static_cast<double>(n);
        const auto ida = dae_reference(model, path.points[first], share * segments[i].d_eps_v, share * segments[i].d_eps_q, samples);
        for (std::size_t k = 0; k < samples; ++k) {
          const ReferencePoint &a = path.points[first + 1 + k], &b = ida[k];
          for (const double d : {a.p - b.p, a.q_signed - b.q_signed, a.preconsolidation - b.preconsolidation})
            result.largest = larger(result.largest, std::abs(d) / scale);
        }
        result.points += static_cast<int>(samples);
      }
      first = last + 1;
    }
  }
  return result;
}

}  // namespace mpm::validation
