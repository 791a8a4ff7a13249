#include "validation/harness/ode_reference.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libmpm/base/error.hpp"
#include "validation/harness/hencky_kinematics.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/root.hpp"
#include "validation/harness/sundials.hpp"

namespace mpm::validation {
namespace {

/// Everything the rate equations need at one state; named as in the header.
struct Local {
  double p, q, internal, pc;
  double y, y_p, y_q;
  double numerator;    // A
  double denominator;  // D
  double stiffness;    // K y_p^2 + 3 G y_q^2, the scale of D
};

Local local_state(const CamClay& m, double p, double q, double internal) {
  Local s{};
  const double mm = m.critical_state_slope * m.critical_state_slope, b = m.cohesion_beta;
  s.p = p;
  s.q = q;
  s.internal = internal;
  s.pc = m.preconsolidation(internal);
  s.y = m.yield(p, q, internal);
  s.y_p = mm * (2.0 * p - (1.0 - b) * s.pc);
  s.y_q = 2.0 * (1.0 + 2.0 * b) * q;
  s.stiffness = m.bulk_modulus * s.y_p * s.y_p + 3.0 * m.shear_modulus * s.y_q * s.y_q;
  s.denominator = s.stiffness + mm * ((1.0 - b) * p + 2.0 * b * s.pc) * s.y_p * m.hardening_xi * std::hypot(m.bulk_modulus, s.pc);
  return s;
}

/// g', with a term that lets errors of y decay as fast as p_c^4: consistency alone keeps y at whatever round-off made it, and
/// y/p_c^2 would grow while p_c falls. For y = 0 the term vanishes, so the solution is unchanged (Baumgarte 1972).
double plastic_rate(const CamClay& m, const Local& s) {
  const double rate = std::max(0.0, s.numerator) / s.denominator;
  const double softening = m.hardening_xi * std::hypot(m.bulk_modulus, s.pc) / s.pc * std::abs(rate * s.y_p);  // |p_c'| / p_c
  return std::max(0.0, s.numerator + 4.0 * softening * s.y) / s.denominator;
}

/// What the two forms have in common: a state vector with its invariants and rates, for one segment at a time.
class Form {
 public:
  explicit Form(const CamClay& model) : m(model) {}
  virtual ~Form() = default;
  virtual void begin_segment(const ReferenceSegment&, double eps_v_now, const std::vector<double>& y) = 0;
  virtual void end_segment() = 0;
  [[nodiscard]] virtual Local local(double t, const double* y) const = 0;
  virtual void rates(double t, const double* y, bool plastic, double* dydt) const = 0;
  /// The point of the path at state y.
  [[nodiscard]] virtual ReferencePoint point(double t, const double* y) const = 0;
  [[nodiscard]] virtual double eps_v(double t, const double* y) const = 0;
  [[nodiscard]] virtual double volumetric_rate() const = 0;
  [[nodiscard]] virtual double deviatoric_rate() const = 0;  ///< sqrt(2/3)|dev d|, signed on coaxial paths
  /// Replaces stress (p, |q|; direction kept, or that of the strain rate where there is none) and internal variable.
  virtual void set(std::vector<double>& y, double p, double q, double internal) const = 0;
  std::vector<double> initial;

 protected:
  const CamClay& m;
};

/// Unknowns p/K, q/K (signed), X, eps_v.
class CoaxialForm final : public Form {
 public:
  explicit CoaxialForm(const CamClay& model) : Form(model) { initial = {0.0, 0.0, model.initial_internal(), 0.0}; }

  void begin_segment(const ReferenceSegment& s, double eps_v_now, const std::vector<double>& y) override {
    if (s.control == ReferenceSegment::Control::velocity_gradient)
      throw ConfigError("coaxial_reference: a velocity gradient needs general_reference");
    const double radial = m.bulk_modulus * (y[0] - y[1] / 3.0);
    if (s.control == ReferenceSegment::Control::drained_triaxial && std::abs(radial - s.radial_stress) > 1e-8 * m.preconsolidation_pressure)
      throw ConfigError(
          fmt::format("coaxial_reference: a drained segment at {} Pa starts from a radial stress of {} Pa", s.radial_stress, radial));
    segment_ = s;
    eps_v_start_ = eps_v_now;
  }
  void end_segment() override { eps_q_start_ = eps_q_end_; }
  [[nodiscard]] bool drained() const { return segment_.control == ReferenceSegment::Control::drained_triaxial; }

  /// Strain rates; under drained control eps_v' follows from p' - q'/3 = 0 with eps_q' = eps_v'/3 - eps_axial'.
  void strain_rates(const Local& s, bool plastic, double& ev, double& eq) const {
    if (!drained()) {
      ev = segment_.d_eps_v;
      eq = segment_.d_eps_q;
      return;
    }
    const double k = m.bulk_modulus, g = m.shear_modulus, a = segment_.d_eps_axial;
    if (plastic) {
      const double c = k * s.y_p - g * s.y_q;
      ev = -(g * a + 3.0 * g * s.y_q * a * c / s.denominator) / (-(k + g / 3.0) + c * c / s.denominator);
    } else {
      ev = g * a / (k + g / 3.0);
    }
    eq = ev / 3.0 - a;
  }
  [[nodiscard]] Local local(double, const double* y) const override {
    Local s = local_state(m, m.bulk_modulus * y[0], m.bulk_modulus * y[1], y[2]);
    double ev = 0.0, eq = 0.0;
    strain_rates(s, true, ev, eq);
    s.numerator = -m.bulk_modulus * s.y_p * ev + 3.0 * m.shear_modulus * s.y_q * eq;
    return s;
  }
  void rates(double t, const double* y, bool plastic, double* dydt) const override {
    const Local s = local(t, y);
    double ev = 0.0, eq = 0.0;
    strain_rates(s, plastic, ev, eq);
    const double g = plastic ? plastic_rate(m, s) : 0.0;
    dydt[0] = -ev - g * s.y_p;
    dydt[1] = 3.0 * m.shear_modulus / m.bulk_modulus * (eq - g * s.y_q);
    dydt[2] = g * s.y_p;
    dydt[3] = ev;
  }
  [[nodiscard]] ReferencePoint point(double t, const double* y) const override {
    ReferencePoint r{};
    r.eps_v = y[3];
    // under drained control eps_q = eps_v/3 - eps_axial holds for the sums too, since it holds for every increment from zero
    r.eps_q = drained() ? eps_q_start_ + (y[3] - eps_v_start_) / 3.0 - segment_.d_eps_axial * t : eps_q_start_ + segment_.d_eps_q * t;
    eps_q_end_ = r.eps_q;
    r.p = m.bulk_modulus * y[0];
    r.q_signed = m.bulk_modulus * y[1];
    r.q = std::abs(r.q_signed);
    r.internal = y[2];
    r.preconsolidation = m.preconsolidation(y[2]);
    r.stress = Vec3(r.q_signed / 3.0 - r.p, r.q_signed / 3.0 - r.p, -2.0 / 3.0 * r.q_signed - r.p).asDiagonal();
    return r;
  }
  [[nodiscard]] double eps_v(double, const double* y) const override { return y[3]; }
  [[nodiscard]] double volumetric_rate() const override {
    if (drained()) throw ConfigError("coaxial_reference: stress-free snow cannot hold a radial stress");
    return segment_.d_eps_v;
  }
  [[nodiscard]] double deviatoric_rate() const override { return segment_.d_eps_q; }
  void set(std::vector<double>& y, double p, double q, double internal) const override {
    const double sign = y[1] != 0.0 ? y[1] : segment_.d_eps_q;
    y[0] = p / m.bulk_modulus;
    y[1] = std::copysign(q, sign) / m.bulk_modulus;
    y[2] = internal;
  }

 private:
  ReferenceSegment segment_;
  double eps_q_start_ = 0.0, eps_v_start_ = 0.0;
  mutable double eps_q_end_ = 0.0;
};

/// Unknowns b_e - I (xx yy zz xy xz yz: the difference keeps small strains exact), X.
class GeneralForm final : public Form {
 public:
  explicit GeneralForm(const CamClay& model) : Form(model) { initial = {0, 0, 0, 0, 0, 0, model.initial_internal()}; }

  void begin_segment(const ReferenceSegment& s, double, const std::vector<double>&) override {
    gradient_ = segment_gradient(s, "general_reference");
    rate_ = 0.5 * (gradient_ + gradient_.transpose());
  }
  void end_segment() override {
    deformation_ = deformed(deformation_, gradient_, 1.0);
    eps_v_start_ += gradient_.trace();
  }

  struct Spectral {
    Local local;
    Mat3 h, s;  ///< b_e - I, deviator of the stress
  };
  [[nodiscard]] Spectral spectral(const double* y) const {
    const HenckyStress stress = hencky_stress(y, m.bulk_modulus, m.shear_modulus);
    Spectral r{local_state(m, stress.p, stress.q, y[6]), stress.h, stress.deviator};
    r.local.numerator = -m.bulk_modulus * r.local.y_p * rate_.trace() +
                        6.0 * m.shear_modulus * (1.0 + 2.0 * m.cohesion_beta) * r.s.cwiseProduct(rate_).sum();
    return r;
  }
  [[nodiscard]] Local local(double, const double* y) const override { return spectral(y).local; }
  void rates(double, const double* y, bool plastic, double* dydt) const override {
    const Spectral r = spectral(y);
    const double g = plastic ? plastic_rate(m, r.local) : 0.0;
    const Mat3 normal = -r.local.y_p / 3.0 * Mat3::Identity() + 3.0 * (1.0 + 2.0 * m.cohesion_beta) * r.s;
    hencky_rates(r.h, gradient_, g, normal, dydt);
    dydt[6] = g * r.local.y_p;
  }
  [[nodiscard]] ReferencePoint point(double t, const double* y) const override {
    const Spectral here = spectral(y);
    const Local& s = here.local;
    ReferencePoint r{};
    r.eps_v = eps_v(t, y);
    r.eps_q = deviatoric_strain(deformed(deformation_, gradient_, t));
    r.p = s.p;
    r.q = r.q_signed = s.q;
    r.internal = s.internal;
    r.preconsolidation = s.pc;
    r.stress = here.s - s.p * Mat3::Identity();
    return r;
  }
  [[nodiscard]] double eps_v(double t, const double*) const override { return eps_v_start_ + gradient_.trace() * t; }
  [[nodiscard]] double volumetric_rate() const override { return rate_.trace(); }
  [[nodiscard]] double deviatoric_rate() const override { return std::sqrt(2.0 / 3.0) * rate_deviator().norm(); }
  void set(std::vector<double>& y, double p, double q, double internal) const override {
    const Spectral r = spectral(y.data());
    const Mat3 direction = r.local.q > 0.0 ? r.s : Mat3(2.0 * m.shear_modulus * rate_deviator());
    y = hencky_unknowns(p, q, direction, internal, m.bulk_modulus, m.shear_modulus);
  }

 private:
  [[nodiscard]] Mat3 rate_deviator() const { return rate_ - rate_.trace() / 3.0 * Mat3::Identity(); }
  Mat3 gradient_ = Mat3::Zero(), rate_ = Mat3::Zero(), deformation_ = Mat3::Identity();
  double eps_v_start_ = 0.0;
};

enum class Phase { elastic, plastic, stress_free };

/// Below these fractions the integration stops before the singular point itself, where the rates are 0/0 or infinite.
constexpr double exhausted_share = 1e-7;  // p_c / p_c0: the stress left is 1e-7 of the initial strength
constexpr double snap_share = 1e-6;       // D / (K y_p^2 + 3 G y_q^2): D falls like a square root, so 1e-12 of the path is left

/// The state to which backward Euler jumps at a snap-back with the strain held.
Landing snap_landing(const CamClay& m, const Local& before) {
  // The state is the root that has just ceased to be stable. Inside already 1e-5 X_n away: the surface closed again at once.
  const Landing to = nearest_landing(m, before.p, std::abs(before.q), before.internal, 1e-5);
  if (to.internal > 0.0 && to.p == 0.0 && to.q == 0.0)
    throw UnstableError(fmt::format("reference path: no state below X = {} at a snap-back", before.internal));
  return to;
}

/// Ray on which stress-free snow starts to carry again at X = 0: p = a p_c, q = b p_c with constant a, b, all from zero.
/// From X' = e'/(1 + xi a), b xi K X' = 3 G (eps_q' - X' y_q/y_p) and y(a, b, 1) = 0, with e' = -eps_v' > 0.
Landing recompaction_ray(const CamClay& m, double e_rate, double q_rate) {
  const double b = m.cohesion_beta, mm = m.critical_state_slope * m.critical_state_slope;
  const auto q_of = [&](double a) { return std::sqrt(mm * (a + b) * std::max(0.0, 1.0 - a) / (1.0 + 2.0 * b)); };
  const auto balance = [&](double a) {
    const double q = q_of(a), x = e_rate / (1.0 + m.hardening_xi * a);
    const double y_p = mm * (2.0 * a - (1.0 - b)), y_q = 2.0 * (1.0 + 2.0 * b) * q;
    return (q * m.hardening_xi * m.bulk_modulus * x - 3.0 * m.shear_modulus * q_rate) * y_p + 3.0 * m.shear_modulus * x * y_q;
  };
  // between the critical state (y_p = 0, balance > 0) and the apex (q = 0, balance <= 0)
  const double a = q_rate == 0.0 ? 1.0 : root_between(balance, 0.5 * (1.0 - b), 1.0);
  return {a, q_of(a), e_rate / (1.0 + m.hardening_xi * a)};
}

class PathIntegrator {
 public:
  PathIntegrator(const CamClay& model, Form& form, const ReferenceOptions& options)
      : m_(model),
        form_(form),
        options_(options),
        ode_(
            form.initial.size(), [this](double t, const double* y, double* d) { form_.rates(t, y, phase_ == Phase::plastic, d); },
            options.relative_tolerance, 1e-17) {
    if (!(m_.bulk_modulus > 0 && m_.shear_modulus > 0 && m_.critical_state_slope > 0 && m_.cohesion_beta >= 0 && m_.hardening_xi > 0 &&
          m_.preconsolidation_pressure > 0))
      throw ConfigError("reference path: K, G, M, xi and p_c0 must be positive and beta not negative");
    y_ = form.initial;
  }

  ReferencePath run(const std::vector<ReferenceSegment>& segments) {
    record(0.0);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      segment_ = static_cast<double>(i);
      t_ = 0.0;
      form_.begin_segment(segments[i], form_.eps_v(0.0, y_.data()), y_);
      if (phase_ != Phase::stress_free) choose_phase();
      const auto n = static_cast<double>(options_.samples_per_segment);
      for (std::size_t k = 1; k <= options_.samples_per_segment; ++k) {
        advance(k == options_.samples_per_segment ? 1.0 : static_cast<double>(k) / n);
        record(t_);
      }
      form_.end_segment();
    }
    path_.steps = ode_.steps();
    return std::move(path_);
  }

 private:
  /// On the surface and not unloading is plastic; A = 0 at an apex (pure shear) is neutral loading and stays plastic.
  void choose_phase() {
    const Local s = form_.local(t_, y_.data());
    const double strength = std::max(s.pc, 1e-3 * m_.preconsolidation_pressure);
    const bool on_surface = s.y >= -1e-9 * strength * strength;  // the drift that the reference is allowed
    enter(on_surface && loading(s) >= -1e-10 ? Phase::plastic : Phase::elastic);
  }
  /// A in units of K y times the strain rate, so that one threshold fits all materials.
  [[nodiscard]] double loading(const Local& s) const {
    const double scale = m_.bulk_modulus * std::sqrt(s.stiffness / m_.bulk_modulus);
    return s.numerator / scale;
  }
  void enter(Phase phase) {
    if (phase == Phase::plastic) {
      const Local s = form_.local(t_, y_.data());
      path_.margin = smaller(path_.margin, s.denominator / s.stiffness);
      if (s.denominator <= snap_share * s.stiffness) return snap_back();  // yield begins where no smooth continuation exists
    }
    phase_ = phase;
    if (phase == Phase::elastic) {
      // A point that unloads from the surface starts at y = 0 to round-off, perhaps above: it yields again where it passes the y it has.
      const Local start = form_.local(t_, y_.data());
      elastic_limit_ = std::max(0.0, start.y / (start.pc * start.pc));
      ode_.start(
          t_, y_, 1.0,
          [this](double t, const double* y, double* g) {
            const Local s = form_.local(t, y);
            g[0] = s.y / (s.pc * s.pc) - elastic_limit_;
          },
          {+1}, longest_elastic_step);
    } else if (phase == Phase::plastic) {
      ode_.start(t_, y_, 1.0,
                 [this](double t, const double* y, double* g) {
                   const Local s = form_.local(t, y);
                   g[0] = loading(s);
                   g[1] = s.denominator / s.stiffness - snap_share;
                   g[2] = s.pc / m_.preconsolidation_pressure - exhausted_share;
                 },
                 {-1, -1, -1});
    }
  }
  void snap_back() {
    if (++snaps_ > 100) throw UnstableError(fmt::format("reference path: more than 100 snap-backs near time {}", segment_ + t_));
    const Local s = form_.local(t_, y_.data());
    const Landing to = snap_landing(m_, s);
    log(PathEvent::snap_back, s.internal, to.internal);
    form_.set(y_, to.p, to.q, to.internal);
    if (to.internal > 0.0)
      enter(Phase::plastic);
    else
      phase_ = Phase::stress_free;
  }
  void advance(double target) {
    for (int restarts = 0; t_ < target; ++restarts) {
      if (restarts > 100) throw UnstableError(fmt::format("reference path: more than 100 events near time {}", segment_ + t_));
      if (phase_ == Phase::stress_free) {
        advance_stress_free(target);
        continue;
      }
      const double t_before = t_;
      const std::vector<double> y_before = y_;
      const OdeIntegrator::Stop stop = ode_.advance(target);
      t_ = stop.time;
      take_state();
      if (stop.root < 0) {
        if (phase_ == Phase::elastic && yielded()) find_onset(t_before, y_before);
        continue;
      }
      const double before = form_.local(t_, y_.data()).internal;
      if (phase_ == Phase::elastic) {
        log(PathEvent::onset, before, before);
        enter(Phase::plastic);
      } else if (stop.root == 0) {
        log(PathEvent::unloading, before, before);
        enter(Phase::elastic);
      } else if (stop.root == 1) {
        snap_back();
      } else {
        const double after = m_.initial_internal() - form_.eps_v(t_, y_.data());
        log(PathEvent::exhaustion, before, after);
        form_.set(y_, 0.0, 0.0, after);  // all elastic strain becomes plastic: X may be above zero by 1e-7 of X_0
        phase_ = Phase::stress_free;
      }
    }
  }
  void take_state() {
    const auto state = ode_.state();
    y_.assign(state.begin(), state.end());
  }
  [[nodiscard]] bool yielded() const {
    const Local s = form_.local(t_, y_.data());
    return s.y > (elastic_limit_ + 1e-12) * s.pc * s.pc;  // beyond round-off of a state that stays where it is
  }
  /// An elastic stretch so short that CVODE's root search stepped over it (a reversal after which the point yields again at once): finds
  /// the onset between t_before and now.
  void find_onset(double t_before, const std::vector<double>& y_before) {
    const auto go_to = [&](double time) {
      ode_.start(t_before, y_before, 1.0, {}, {});
      t_ = time > t_before ? ode_.advance(time).time : t_before;
      take_state();
    };
    const auto elastic = [&](double time) {
      go_to(time);
      return !yielded();
    };
    go_to(limit_of(elastic, t_before, t_).second);
    const double internal = form_.local(t_, y_.data()).internal;
    log(PathEvent::onset, internal, internal);
    enter(Phase::plastic);
  }
  /// No stress, all strain plastic: X' = -eps_v', until X = 0.
  void advance_stress_free(double target) {
    const double rate = -form_.volumetric_rate();
    const std::size_t slot = form_.initial.size() == 4 ? 2 : 6;
    const bool coaxial = slot == 2;
    const double x = y_[slot];
    double step = target - t_;
    const bool recompacts = rate > 0.0 && x + rate * step > 0.0;
    if (recompacts) step = -x / rate;
    t_ = recompacts ? t_ + step : target;
    y_[slot] = recompacts ? 0.0 : x + rate * step;
    if (coaxial) y_[3] -= rate * step;
    if (!recompacts) return;
    log(PathEvent::recompaction, 0.0, 0.0);
    // leave the singular point along its ray, far enough that p_c / p_c0 is the fraction that counts as exhausted
    const Landing ray = recompaction_ray(m_, rate, std::abs(form_.deviatoric_rate()));
    const double pc = 4.0 * exhausted_share * m_.preconsolidation_pressure;
    const double internal = std::asinh(pc / m_.bulk_modulus) / m_.hardening_xi;
    const double used = internal / ray.internal;  // ray.internal is X'
    if (t_ + used >= 1.0) {                       // the segment ends at the singular point
      t_ = target;
      return;
    }
    t_ += used;
    if (coaxial) y_[3] -= rate * used;
    form_.set(y_, ray.p * pc, ray.q * pc, internal);
    enter(Phase::plastic);
    if (t_ > target) throw UnstableError("reference path: sampled finer than the recompaction ray resolves");
  }
  void log(PathEvent event, double before, double after) { path_.events.push_back({event, segment_ + t_, before, after}); }
  void record(double t) {
    ReferencePoint r = form_.point(t, y_.data());
    r.time = segment_ + t;
    r.plastic = phase_ == Phase::plastic;
    if (r.plastic) {
      const Local s = form_.local(t, y_.data());
      path_.margin = smaller(path_.margin, s.denominator / s.stiffness);
      const double strength = std::max(r.preconsolidation, 1e-3 * m_.preconsolidation_pressure);
      path_.drift = larger(path_.drift, std::abs(m_.yield(r.p, r.q, r.internal)) / (strength * strength));
    }
    path_.points.push_back(r);
  }

  const CamClay& m_;
  Form& form_;
  const ReferenceOptions& options_;
  Phase phase_ = Phase::elastic;
  OdeIntegrator ode_;
  std::vector<double> y_;
  double t_ = 0.0, segment_ = 0.0;
  double elastic_limit_ = 0.0;  // y / p_c^2 at which the current elastic phase ends
  int snaps_ = 0;
  ReferencePath path_;
};

}  // namespace

CamClay CamClay::from_young(double young, double poisson, double m, double beta, double xi, double pc0) {
  return {young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)), m, beta, xi, pc0};
}
double CamClay::initial_internal() const { return std::asinh(preconsolidation_pressure / bulk_modulus) / hardening_xi; }
double CamClay::preconsolidation(double internal) const { return bulk_modulus * std::sinh(hardening_xi * std::max(internal, 0.0)); }
double CamClay::yield(double p, double q, double internal) const {
  const double pc = preconsolidation(internal);
  return q * q * (1.0 + 2.0 * cohesion_beta) + critical_state_slope * critical_state_slope * (p + cohesion_beta * pc) * (p - pc);
}

ReferenceSegment ReferenceSegment::strain_increment(double d_eps_v, double d_eps_q) {
  ReferenceSegment s;
  s.d_eps_v = d_eps_v;
  s.d_eps_q = d_eps_q;
  return s;
}
ReferenceSegment ReferenceSegment::drained(double radial_stress, double d_eps_axial) {
  ReferenceSegment s;
  s.control = Control::drained_triaxial;
  s.radial_stress = radial_stress;
  s.d_eps_axial = d_eps_axial;
  return s;
}
ReferenceSegment ReferenceSegment::general(const Mat3& gradient) {
  ReferenceSegment s;
  s.control = Control::velocity_gradient;
  s.gradient = gradient;
  return s;
}

std::string to_string(PathEvent e) {
  switch (e) {
    case PathEvent::onset: return "onset of yield";
    case PathEvent::unloading: return "unloading";
    case PathEvent::exhaustion: return "exhaustion (p_c = 0)";
    case PathEvent::snap_back: return "snap-back";
    case PathEvent::recompaction: return "recompaction";
  }
  return "unknown";
}

ReferencePath coaxial_reference(const CamClay& model, const std::vector<ReferenceSegment>& segments, const ReferenceOptions& options) {
  CoaxialForm form(model);
  return PathIntegrator(model, form, options).run(segments);
}

ReferencePath general_reference(const CamClay& model, const std::vector<ReferenceSegment>& segments, const ReferenceOptions& options) {
  GeneralForm form(model);
  return PathIntegrator(model, form, options).run(segments);
}

std::vector<ReferencePoint> dae_reference(const CamClay& m, const ReferencePoint& start, double d_eps_v, double d_eps_q,
                                          std::size_t samples, double relative_tolerance) {
  const double k = m.bulk_modulus, g = m.shear_modulus;
  const double scale = m.critical_state_slope * m.critical_state_slope * m.preconsolidation_pressure;
  // Onto the surface: the start lies there to the drift of another integrator only, which an index-1 solver takes for a jump.
  double p = start.p, q = start.q_signed / k, internal = start.internal;
  const auto y_x = [&](const Local& s) {  // dy/dX at fixed strain, dp/dX = -K
    const double mm = m.critical_state_slope * m.critical_state_slope;
    return -k * s.y_p - mm * ((1.0 - m.cohesion_beta) * s.p + 2.0 * m.cohesion_beta * s.pc) * m.hardening_xi * std::hypot(k, s.pc);
  };
  for (int i = 0; i < 3; ++i) {
    const Local s = local_state(m, p, k * q, internal);
    const double by_q = k * s.y_q, by_x = y_x(s), share = s.y / (by_q * by_q + by_x * by_x);
    q -= share * by_q;
    internal -= share * by_x;
    p += k * share * by_x;
  }
  // consistent slopes: the first equation and y' = 0, both linear in q' and X'
  const Local first = local_state(m, p, k * q, internal);
  Eigen::Matrix2d a;
  a << -first.y_p, -3.0 * g * first.y_q, first.y_q, y_x(first);
  const Eigen::Vector2d b(-first.y_p * 3.0 * g * d_eps_q, first.y_p * k * d_eps_v);
  const Eigen::Vector2d slope = a.inverse() * b;
  // Unknowns are the increments of q/K and X, so that the relative tolerance is one of what the path adds.
  const auto p_of = [&](double t, double increment) { return p - k * (d_eps_v * t + increment); };
  // In long double, as the iteration of IDA stalls on the round-off of y where the surface has shrunk to a small part.
  const auto yield_of = [&](double t, const double* y) {
    using Real = long double;
    const Real slope_squared = Real(m.critical_state_slope) * m.critical_state_slope, beta = m.cohesion_beta;
    const Real p_now = p - k * (Real(d_eps_v) * t + y[1]), q_now = k * (Real(q) + y[0]);
    const Real pc = k * std::sinh(m.hardening_xi * std::max(Real(0), Real(internal) + y[1]));
    return static_cast<double>(q_now * q_now * (1 + 2 * beta) + slope_squared * (p_now + beta * pc) * (p_now - pc));
  };
  const auto residual = [&](double t, const double* y, const double* dydt, double* r) {
    const Local s = local_state(m, p_of(t, y[1]), k * (q + y[0]), internal + y[1]);
    r[0] = (s.y_p * (3.0 * g * d_eps_q - k * dydt[0]) - 3.0 * g * s.y_q * dydt[1]) / (scale * k);
    r[1] = yield_of(t, y) / (scale * k);
  };
  const auto jacobian = [&](double t, double c, const double* y, const double* dydt, double* rows) {
    const double mm = m.critical_state_slope * m.critical_state_slope, x = internal + y[1];
    const Local here = local_state(m, p_of(t, y[1]), k * (q + y[0]), x);
    const double y_p_by_x = -mm * (2.0 * k + (1.0 - m.cohesion_beta) * m.hardening_xi * std::hypot(k, here.pc));
    rows[0] = -(6.0 * g * (1.0 + 2.0 * m.cohesion_beta) * k * dydt[1] + c * here.y_p * k) / (scale * k);
    rows[1] = (y_p_by_x * (3.0 * g * d_eps_q - k * dydt[0]) - c * 3.0 * g * here.y_q) / (scale * k);
    rows[2] = here.y_q * k / (scale * k);
    rows[3] = y_x(here) / (scale * k);
  };
  std::vector<double> times;
  for (std::size_t i = 1; i <= samples; ++i) times.push_back(static_cast<double>(i) / static_cast<double>(samples));
  // The absolute tolerance starts at a hundred times the round-off of X. Near a fold the iteration cannot meet that, and is given more.
  std::vector<std::vector<double>> states;
  for (double absolute = 2e-14 * internal; states.empty(); absolute *= 4.0) {
    try {
      states = integrate_dae(residual, jacobian, 0.0, {0.0, 0.0}, {slope[0] / k, slope[1]}, times, relative_tolerance, absolute);
    } catch (const UnstableError&) {
      if (absolute > 1e-12) throw;
    }
  }
  std::vector<ReferencePoint> points;
  for (std::size_t i = 0; i < samples; ++i) {
    ReferencePoint r{};
    r.time = times[i];
    r.eps_v = start.eps_v + d_eps_v * times[i];
    r.eps_q = start.eps_q + d_eps_q * times[i];
    r.q_signed = k * (q + states[i][0]);
    r.q = std::abs(r.q_signed);
    r.internal = internal + states[i][1];
    r.p = p_of(times[i], states[i][1]);
    r.preconsolidation = m.preconsolidation(r.internal);
    r.plastic = true;
    points.push_back(r);
  }
  return points;
}

Landing nearest_landing(const CamClay& m, double p_trial, double q_trial, double internal, double skipped) {
  const double mm = m.critical_state_slope * m.critical_state_slope;
  const double stress_free = internal + p_trial / m.bulk_modulus;  // where all elastic volume change has become plastic
  const auto p_of = [&](double x) { return p_trial - m.bulk_modulus * (x - internal); };
  const auto y_p_of = [&](double x) { return mm * (2.0 * p_of(x) - (1.0 - m.cohesion_beta) * m.preconsolidation(x)); };
  const auto at = [&](double x) {
    const double flow = 1.0 + 6.0 * m.shear_modulus * (1.0 + 2.0 * m.cohesion_beta) * (x - internal) / y_p_of(x);
    return Landing{p_of(x), q_trial / flow, x};
  };
  const auto y = [&](double x) {
    const Landing r = at(x);
    return m.yield(r.p, r.q, x);
  };
  // Equal ratios of X_n - X down to half of X_n, then equal ratios of X: roots lie close together at either end.
  constexpr int samples = 4000;
  constexpr double last = 1e-12;
  const auto scanned = [&](int i) {
    const double share = static_cast<double>(i % samples) / samples;
    return internal * (i < samples ? 1.0 - skipped * std::pow(0.5 / skipped, share) : 0.5 * std::pow(2.0 * last, share));
  };
  double above = scanned(0);
  if (y(above) <= 0.0) return at(above);
  for (int i = 1; i < 2 * samples; ++i) {
    const double x = scanned(i);
    if (y_p_of(x) >= 0.0) break;  // X falls on the dilative side only
    if (y(x) <= 0.0) return at(root_between(y, above, x));
    above = x;
  }
  return {0.0, 0.0, stress_free};
}

namespace exact {

double isotropic_compression(const CamClay& m, double compression) {
  const double total = compression + m.initial_internal();
  return root_between([&](double x) { return std::sinh(m.hardening_xi * x) + x - total; }, 0.0, total);
}
double tension_apex(const CamClay& m, double compression, double start) {
  const double total = compression + m.initial_internal();
  // h(X) = X - beta sinh(xi max(X, 0)) is X below zero; above, it rises to X* = acosh(1/(beta xi))/xi and falls from there
  // (it falls at once for beta xi >= 1). Outside the apex h(start) > total, so the root below start is on the rising part.
  if (total <= 0.0 || m.cohesion_beta == 0.0) return total;
  const double top = std::acosh(1.0 / (m.cohesion_beta * m.hardening_xi)) / m.hardening_xi;
  return root_between([&](double x) { return x - m.cohesion_beta * std::sinh(m.hardening_xi * x) - total; }, 0.0, std::min(start, top));
}
double isotropic(const CamClay& m, double compression, double internal) {
  const double total = compression + m.initial_internal(), p = m.bulk_modulus * (total - internal), pc = m.preconsolidation(internal);
  if (p > pc) return total <= 0.0 ? total : isotropic_compression(m, compression);
  if (p < -m.cohesion_beta * pc) return tension_apex(m, compression, internal);
  return internal;
}
double isochoric_critical_state(const CamClay& m, double compression) {
  const double total = compression + m.initial_internal();
  return root_between([&](double x) { return 0.5 * (1.0 - m.cohesion_beta) * std::sinh(m.hardening_xi * x) + x - total; }, 0.0, total);
}
double critical_ratio(const CamClay& m) {
  return m.critical_state_slope * (1.0 + m.cohesion_beta) / ((1.0 - m.cohesion_beta) * std::sqrt(1.0 + 2.0 * m.cohesion_beta));
}
double drained_critical_pressure(const CamClay& m, double isotropic_pressure, bool extension) {
  return 3.0 * isotropic_pressure / (3.0 + (extension ? 1.0 : -1.0) * critical_ratio(m));
}
double yield_without_pressure(const CamClay& m, double internal) {
  return m.critical_state_slope * m.preconsolidation(internal) * std::sqrt(m.cohesion_beta / (1.0 + 2.0 * m.cohesion_beta));
}
Mat3 hencky_simple_shear(double shear_modulus, double gamma) {
  const double s = std::asinh(0.5 * gamma) / std::sqrt(1.0 + 0.25 * gamma * gamma);
  Mat3 tau = Mat3::Zero();
  tau(0, 1) = tau(1, 0) = 2.0 * shear_modulus * s;
  tau(0, 0) = shear_modulus * gamma * s;
  tau(1, 1) = -tau(0, 0);
  return tau;
}

}  // namespace exact
}  // namespace mpm::validation
