#include "validation/harness/cone_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/base/error.hpp"
#include "validation/harness/hencky_kinematics.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/sundials.hpp"

namespace mpm::validation {
namespace {

constexpr double apex_share = 1e-10;  ///< q over the largest stress of the path: closer to the apex the flow direction is lost
constexpr double ray_share = 1e-9;    ///< of a segment: how far along its ray the stress is led after recompaction

/// Everything the rate equations need at one state.
struct Local : HenckyStress {
  double f;
  double numerator;  ///< of g' without rate dependence
};

class ConeIntegrator {
 public:
  ConeIntegrator(const Cone& cone, const ReferenceOptions& options)
      : m_(cone),
        options_(options),
        ode_(
            7, [this](double, const double* y, double* d) { rates(y, d); }, options.relative_tolerance, 1e-17),
        y_(7, 0.0) {}

  ReferencePath run(const std::vector<ReferenceSegment>& segments) {
    record();
    for (std::size_t i = 0; i < segments.size(); ++i) {
      segment_ = static_cast<double>(i);
      t_ = 0.0;
      begin(segments[i]);
      if (scale_ == 0.0 && m_.intercept == 0.0 && gradient_.trace() != 0.0) phase_ = Phase::torn;  // the apex itself, with no gap
      if (phase_ != Phase::torn) choose_phase();
      for (std::size_t k = 1; k <= options_.samples_per_segment; ++k) {
        advance(k == options_.samples_per_segment ? 1.0 : static_cast<double>(k) / static_cast<double>(options_.samples_per_segment));
        record();
      }
      deformation_ = deformed(deformation_, gradient_, 1.0);
      eps_v_start_ += gradient_.trace();
    }
    path_.steps = ode_.steps();
    return std::move(path_);
  }

 private:
  enum class Phase { elastic, plastic, torn };

  void begin(const ReferenceSegment& s) {
    gradient_ = segment_gradient(s, "cone_reference");
    rate_ = 0.5 * (gradient_ + gradient_.transpose());
  }
  [[nodiscard]] bool by_rate() const { return m_.slope_increase > 0.0; }
  [[nodiscard]] double apex_pressure() const { return -m_.intercept / m_.slope; }
  [[nodiscard]] double eps_v() const { return eps_v_start_ + gradient_.trace() * t_; }
  [[nodiscard]] Mat3 rate_deviator() const { return rate_ - rate_.trace() / 3.0 * Mat3::Identity(); }

  [[nodiscard]] Local local(const double* y) const {
    Local r{hencky_stress(y, m_.bulk_modulus, m_.shear_modulus), 0.0, 0.0};
    r.f = r.q - m_.slope * r.p - m_.intercept;
    r.numerator = m_.slope * m_.bulk_modulus * rate_.trace();
    if (r.q > 0.0) r.numerator += 3.0 * m_.shear_modulus / r.q * r.deviator.cwiseProduct(rate_).sum();
    return r;
  }
  [[nodiscard]] double plastic_rate(const Local& s) const {
    if (!by_rate()) return std::max(0.0, s.numerator) / (3.0 * m_.shear_modulus + m_.bulk_modulus * m_.slope * m_.dilatancy);
    if (s.f <= 0.0) return 0.0;
    const double rest = m_.slope_increase * s.p - s.f;
    if (!(rest > 0.0)) throw UnstableError("cone_reference: shear stress beyond the limit of mu(I)");
    return m_.reference_number * s.f / rest * std::sqrt(s.p / m_.grain_density) / (std::numbers::sqrt3 * m_.grain_diameter);
  }
  void rates(const double* y, double* dydt) const {
    const Local r = local(y);
    const double g = phase_ == Phase::plastic ? plastic_rate(r) : 0.0;
    Mat3 normal = m_.dilatancy / 3.0 * Mat3::Identity();
    if (r.q > 0.0) normal += 1.5 / r.q * r.deviator;
    hencky_rates(r.h, gradient_, g, normal, dydt);
    dydt[6] = g * m_.dilatancy;
  }

  /// Where f counts as zero, Pa.
  [[nodiscard]] double on_surface() const { return 1e-9 * std::max(scale_, m_.intercept); }
  void choose_phase() {
    const Local s = local(y_.data());
    // A rate along the surface, whose numerator has either sign by round-off, loads: f is convex.
    const double along = 1e-9 * m_.shear_modulus * rate_.norm();
    const bool plastic = by_rate() ? s.f > 0.0 : s.q > 0.0 && s.f >= -on_surface() && s.numerator > -along;
    enter(plastic ? Phase::plastic : Phase::elastic);
  }
  void enter(Phase phase) {
    phase_ = phase;
    if (phase == Phase::elastic) {
      const double start = std::max(0.0, local(y_.data()).f);  // round-off of a state that unloads from the surface
      ode_.start(
          t_, y_, 1.0, [this, start](double, const double* y, double* g) { g[0] = local(y).f - start; }, {+1}, longest_elastic_step);
    } else if (phase == Phase::plastic) {
      ode_.start(t_, y_, 1.0,
                 [this](double, const double* y, double* g) {
                   const Local s = local(y);
                   g[0] = by_rate() ? s.f : s.numerator;
                   g[1] = s.q - apex_share * scale_;
                 },
                 {-1, -1});
    }
  }
  void set(double p, double q, const Mat3& direction, double internal) {
    y_ = hencky_unknowns(p, std::max(q, 0.0), direction, internal, m_.bulk_modulus, m_.shear_modulus);
  }
  void advance(double target) {
    for (int restarts = 0; t_ < target; ++restarts) {
      if (restarts > 100) throw UnstableError(fmt::format("cone_reference: more than 100 events near time {}", segment_ + t_));
      if (phase_ == Phase::torn) {
        advance_torn(target);
        continue;
      }
      const OdeIntegrator::Stop stop = ode_.advance(target);
      t_ = stop.time;
      y_.assign(ode_.state().begin(), ode_.state().end());
      if (stop.root < 0) continue;
      if (phase_ == Phase::elastic) {
        log(PathEvent::onset);
        enter(Phase::plastic);
      } else if (stop.root == 0) {
        log(PathEvent::unloading);
        enter(Phase::elastic);
      } else {
        log(PathEvent::exhaustion);
        phase_ = Phase::torn;
      }
    }
  }
  /// At the apex, or free of stress with a gap to close.
  void advance_torn(double target) {
    const double rate = gradient_.trace(), apex = apex_pressure();
    if (rate < 0.0 && m_.intercept > 0.0) throw ConfigError("cone_reference: cohesive material that closes is not covered");
    const auto gap = [&](double t) { return eps_v_start_ + rate * t + apex / m_.bulk_modulus; };
    if (gap(target) > 0.0 || rate >= 0.0) {
      t_ = target;
      set(apex, 0.0, Mat3::Zero(), gap(t_));
      return;
    }
    t_ = std::max(t_, -eps_v_start_ / rate);
    log(PathEvent::recompaction);
    const double shear = std::sqrt(2.0 / 3.0) * rate_deviator().norm();
    if (by_rate() && 3.0 * m_.shear_modulus * shear > -m_.slope * m_.bulk_modulus * rate)
      throw ConfigError("cone_reference: rate-dependent material that yields where it has no stress is not covered");
    const double k = m_.bulk_modulus, g = m_.shear_modulus;
    const double flow = std::max(0.0, (3.0 * g * shear + m_.slope * k * rate) / (3.0 * g + m_.slope * k * m_.dilatancy));
    const double used = std::min(ray_share, target - t_);
    set(k * (-rate + m_.dilatancy * flow) * used, 3.0 * g * (shear - flow) * used, rate_deviator(), m_.dilatancy * flow * used);
    t_ += used;
    enter(flow > 0.0 ? Phase::plastic : Phase::elastic);
  }
  void log(PathEvent event) { path_.events.push_back({event, segment_ + t_, y_[6], y_[6]}); }
  void record() {
    const Local s = local(y_.data());
    ReferencePoint r{};
    r.time = segment_ + t_;
    r.eps_v = eps_v();
    r.eps_q = deviatoric_strain(deformed(deformation_, gradient_, t_));
    r.p = s.p;
    r.q = r.q_signed = s.q;
    r.internal = y_[6];
    r.plastic = phase_ == Phase::plastic;
    r.stress = s.deviator - s.p * Mat3::Identity();
    scale_ = std::max({scale_, std::abs(s.p), s.q});
    if (r.plastic && !by_rate()) path_.drift = larger(path_.drift, std::abs(s.f) / std::max(scale_, m_.intercept));
    path_.points.push_back(r);
  }

  Cone m_;
  ReferenceOptions options_;
  Phase phase_ = Phase::elastic;
  OdeIntegrator ode_;
  std::vector<double> y_;  ///< b_e - I (xx yy zz xy xz yz), X
  Mat3 gradient_ = Mat3::Zero(), rate_ = Mat3::Zero(), deformation_ = Mat3::Identity();
  double eps_v_start_ = 0.0, t_ = 0.0, segment_ = 0.0, scale_ = 0.0;
  ReferencePath path_;
};

}  // namespace

Cone Cone::of(const DruckerPrager::Parameters& p) {
  const double k = p.young_modulus / (3.0 * (1.0 - 2.0 * p.poisson_ratio)), g = p.young_modulus / (2.0 * (1.0 + p.poisson_ratio));
  Cone c{.bulk_modulus = k, .shear_modulus = g, .slope = 0.0, .intercept = 0.0};
  const auto triaxial = [](double angle) { return 6.0 * std::sin(angle) / (3.0 - std::sin(angle)); };
  const auto shear = [](double angle) { return std::numbers::sqrt3 * std::tan(angle); };
  switch (p.cone_matching) {
    case ConeMatching::triaxial_compression:
      c.slope = triaxial(p.friction_angle);
      c.dilatancy = triaxial(p.dilatancy_angle);
      c.intercept = 6.0 * p.cohesion * std::cos(p.friction_angle) / (3.0 - std::sin(p.friction_angle));
      if (p.limit_friction_angle) c.slope_increase = triaxial(*p.limit_friction_angle) - c.slope;
      break;
    case ConeMatching::simple_shear:
      c.slope = shear(p.friction_angle);
      c.dilatancy = shear(p.dilatancy_angle);
      c.intercept = std::numbers::sqrt3 * p.cohesion;
      if (p.limit_friction_angle) c.slope_increase = shear(*p.limit_friction_angle) - c.slope;
      break;
    case ConeMatching::plane_strain: throw ConfigError("cone_reference: matching by triaxial compression or simple shear only");
  }
  if (p.limit_friction_angle) {
    c.reference_number = *p.reference_inertial_number;
    c.grain_diameter = *p.grain_diameter;
    c.grain_density = *p.grain_density;
  }
  return c;
}

ReferencePath cone_reference(const Cone& cone, const std::vector<ReferenceSegment>& segments, const ReferenceOptions& options) {
  return ConeIntegrator(cone, options).run(segments);
}

}  // namespace mpm::validation
