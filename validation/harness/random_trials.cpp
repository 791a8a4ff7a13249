#include "validation/harness/random_trials.hpp"

#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace mpm::validation {
namespace {

/// Counter-based (SplitMix64, Steele et al. 2014).
class Draw {
 public:
  explicit Draw(std::uint64_t stream) : state_(stream * 0xd1342543de82ef95ULL + 0x2545f4914f6cdd1dULL) {}
  /// [0, 1)
  double unit() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  double symmetric() { return 2.0 * unit() - 1.0; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double decades(double low, double high) { return low * std::pow(high / low, unit()); }

 private:
  std::uint64_t state_;
};

double pressure(const Sym3<double>& s) { return -trace(s) / 3.0; }
double shear(const Sym3<double>& s) { return std::sqrt(1.5 * norm2(deviator(s))); }

double determinant(const Matrix3<double>& dl) {
  const auto& m = dl.m;
  const double xx = 1.0 + m[0][0], yy = 1.0 + m[1][1], zz = 1.0 + m[2][2];
  return xx * (yy * zz - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * zz - m[1][2] * m[2][0]) + m[0][2] * (m[1][0] * m[2][1] - yy * m[2][0]);
}

MaterialState<double> draw_state(Draw& draw, const mpm::CamClay& law, const mpm::CamClay::Parameters& spec) {
  if (draw.unit() < 0.15) return {{}, -draw.decades(1e-6, 0.3)};  // expanded: stress-free
  const double bulk = law.moduli().bulk();
  // elastic strains up to 1/2 in volume and in shear: beyond, b_e = exp(2 eps) itself has lost digits
  const double highest_q =
      0.5 * (1.0 + spec.cohesion_beta) / std::sqrt(1.0 + 2.0 * spec.cohesion_beta) * spec.critical_state_slope;  // over p_c
  const double most = std::min(0.5 * bulk, 1.5 * law.moduli().shear() / std::max(highest_q, 1e-3));
  const double p_c = std::min(spec.preconsolidation_pressure * draw.decades(1e-4, 1e4), most);
  MaterialState<double> s{{}, std::asinh(p_c / bulk) / spec.hardening_xi};
  const double centre = 0.5 * (1.0 - spec.cohesion_beta) * p_c, radius = 0.5 * (1.0 + spec.cohesion_beta) * p_c;
  const double angle = 3.14159 * draw.unit(), r = draw.unit() < 0.3 ? 1.0 : std::sqrt(draw.unit());
  const double p = centre + r * radius * std::cos(angle);
  const double q =
      draw.unit() < 0.1 ? 0.0 : r * radius * std::sin(angle) * spec.critical_state_slope / std::sqrt(1.0 + 2.0 * spec.cohesion_beta);
  const Sym3<double> direction =
      deviator(Sym3<double>{draw.symmetric(), draw.symmetric(), draw.symmetric(), draw.symmetric(), draw.symmetric(), draw.symmetric()});
  s.stress = (q / std::sqrt(1.5 * norm2(direction))) * direction;
  s.stress.xx -= p, s.stress.yy -= p, s.stress.zz -= p;
  return s;
}

Matrix3<double> draw_increment(Draw& draw) {
  for (;;) {
    const double size = draw.decades(1e-9, 0.5), volume = draw.unit() < 0.5 ? size * draw.symmetric() : 0.0;
    const bool isotropic = draw.unit() < 0.1;
    Matrix3<double> dl{};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) dl.m[a][b] = (a == b ? volume : 0.0) + (isotropic ? 0.0 : std::clamp(size * draw.symmetric(), -0.5, 0.5));
    if (determinant(dl) > 0.1) return dl;  // far from inversion, where b_e loses its digits
  }
}

/// Round-off granted. The trial stress is good to 3e-14 K (a trial strain up to about 1, and shear moduli up to 1.5 K), in p and in q; the
/// law lets a state exceed the surface by 1e-13 of p_c^2.
struct Bound {
  double stress;  ///< Pa
  double yield;   ///< Pa^2: that error times the largest slopes of y, |y_p| <= M^2 (1 + beta) p_c and |y_q| <= 2 M (1 + beta) sqrt(1 + 2
                  ///< beta) p_c
  Bound(const mpm::CamClay& law, const mpm::CamClay::Parameters& spec, double p_c) {
    const double m = spec.critical_state_slope, b = spec.cohesion_beta;
    stress = 3e-14 * law.moduli().bulk();
    yield = stress * (m * m * (1.0 + b) + 2.0 * m * (1.0 + b) * std::sqrt(1.0 + 2.0 * b)) * p_c +
            1e-12 * m * m * (1.0 + b) * (1.0 + b) * p_c * p_c + (1.0 + 2.0 * b + m * m) * stress * stress;
  }
};

std::string describe(const mpm::CamClay::Parameters& spec, const Trial& t, const MaterialState<double>& after) {
  return fmt::format(
      "M {:.6g}, β {:.6g}, ξ {:.6g}, p_c0 {:.6g} Pa, E {:.6g} Pa, ν {:.6g}: p {:.8g}, q {:.8g}, X {:.10g} by |dl| {:.3g} to p {:.8g}, q "
      "{:.8g}, X {:.10g}",
      spec.critical_state_slope, spec.cohesion_beta, spec.hardening_xi, spec.preconsolidation_pressure, spec.young_modulus,
      spec.poisson_ratio, pressure(t.state.stress), shear(t.state.stress), t.state.internal,
      std::sqrt(t.dl.m[0][0] * t.dl.m[0][0] + t.dl.m[1][1] * t.dl.m[1][1] + t.dl.m[2][2] * t.dl.m[2][2]), pressure(after.stress),
      shear(after.stress), after.internal);
}

/// Takes a larger value; a NaN stays.
template <class Where>
void note(WorstOf& worst, double value, const Where& where) {
  if (!(value > worst.value) && !std::isnan(value)) return;
  worst = {value, where()};
}

}  // namespace

TrialGroup draw_trials(std::uint64_t group) {
  Draw draw(group);
  TrialGroup g;
  g.spec.critical_state_slope = draw.unit() < 0.1 ? 0.0 : draw.decades(1e-3, 3.0);
  g.spec.cohesion_beta = draw.unit() < 0.2 ? 0.0 : draw.decades(1e-3, 0.9);
  g.spec.hardening_xi = draw.decades(0.02, 50.0);
  g.spec.preconsolidation_pressure = draw.decades(1.0, 1e6);
  g.spec.young_modulus = draw.decades(1e5, 1e8);
  g.spec.poisson_ratio = draw.between(0.0, 0.45);
  const mpm::CamClay law(g.spec);
  g.trials.reserve(TrialGroup::size);
  for (int i = 0; i < TrialGroup::size; ++i) {
    const MaterialState<double> state = draw_state(draw, law, g.spec);
    g.trials.push_back({state, draw_increment(draw)});
  }
  return g;
}

void TrialReport::merge(const TrialReport& o) {
  states += o.states, plastic += o.plastic, compacting += o.compacting, dilating += o.dilating, stress_free += o.stress_free;
  not_finite += o.not_finite;
  for (WorstOf TrialReport::*worst :
       {&TrialReport::outside, &TrialReport::off_surface, &TrialReport::negative_work, &TrialReport::lanes_difference})
    note(this->*worst, (o.*worst).value, [&] { return (o.*worst).where; });
}

void judge(const mpm::CamClay& law, const mpm::CamClay::Parameters& spec, const Trial& trial, const MaterialState<double>& after,
           TrialReport& report) {
  const auto where = [&] { return describe(spec, trial, after); };
  const double p = pressure(after.stress), q = shear(after.stress), d_x = after.internal - trial.state.internal;
  ++report.states;
  if (!std::isfinite(p + q + after.internal)) {
    ++report.not_finite;
    return;
  }
  const double p_c = law.preconsolidation_pressure(after.internal);
  const Bound bound(law, spec, p_c);

  const double q_trial = shear(law.moduli().stress(hencky_trial(law.moduli().strain(trial.state.stress), trial.dl)));
  const double shear_slip = (q_trial - q) / (3.0 * law.moduli().shear());  // eps_q^P of the step
  const bool plastic = d_x != 0.0;
  report.plastic += plastic ? 1 : 0;
  report.compacting += d_x > 0.0 ? 1 : 0;
  report.dilating += d_x < 0.0 ? 1 : 0;
  report.stress_free += p_c == 0.0 ? 1 : 0;

  if (spec.critical_state_slope > 0.0) {
    const double y = law.yield_function(after);
    note(report.outside, y / bound.yield, where);
    if (plastic && p_c > 0.0) note(report.off_surface, std::abs(y) / bound.yield, where);
  } else {  // y does not bound p there: q = 0 and -beta p_c <= p <= p_c
    const double granted = bound.stress + 1e-12 * p_c;
    note(report.outside, std::max({p - p_c, -p - spec.cohesion_beta * p_c, q}) / granted, where);
    if (plastic) note(report.off_surface, std::min(std::abs(p - p_c), std::abs(p + spec.cohesion_beta * p_c)) / granted, where);
  }
  const double work = p * d_x + q * shear_slip, granted = bound.stress * (std::abs(d_x) + std::abs(shear_slip)) + 1e-13 * (p_c + q);
  if (work < 0.0) note(report.negative_work, -work / granted, where);
}

void compare(const mpm::CamClay& law, const mpm::CamClay::Parameters& spec, const Trial& trial, const MaterialState<double>& a,
             const MaterialState<double>& b, TrialReport& report) {
  const double scale = std::max(law.preconsolidation_pressure(a.internal), 1e-3 * law.moduli().bulk());
  const Sym3<double> d = a.stress - b.stress;
  double e = std::abs(a.internal - b.internal) / (1e-11 * std::max(std::abs(a.internal), 1e-3));
  for (const double s : {d.xx, d.yy, d.zz, d.xy, d.xz, d.yz}) e = larger(e, std::abs(s) / (1e-11 * scale));
  note(report.lanes_difference, e, [&] { return describe(spec, trial, b); });
}

TrialReport try_random_states(std::int64_t states) {
  const std::int64_t groups = (states + TrialGroup::size - 1) / TrialGroup::size, chunk = 256, chunks = (groups + chunk - 1) / chunk;
  std::vector<TrialReport> parts(static_cast<std::size_t>(chunks));
  in_parallel(parts.size(), [&](std::size_t i) {
    const auto c = static_cast<std::int64_t>(i);
    for (std::int64_t g = c * chunk; g < std::min((c + 1) * chunk, groups); ++g)
      parts[i].merge(try_group(draw_trials(static_cast<std::uint64_t>(g)), LibraryMap{}));
  });
  TrialReport report;
  for (const TrialReport& part : parts) report.merge(part);
  return report;
}

}  // namespace mpm::validation
