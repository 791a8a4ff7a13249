#include "libmpm/material/cam_clay.hpp"

#include <limits>

#include "libmpm/base/parameter.hpp"

namespace mpm {

CamClay::CamClay(const Parameters& p) : moduli_(checked(p)), slope_(p.critical_state_slope), beta_(p.cohesion_beta), xi_(p.hardening_xi) {
  m2_ = slope_ * slope_ / (1.0 + 2.0 * beta_);
  c_ = m2_ > 0.0 ? 6.0 * moduli_.shear() / (moduli_.bulk() * m2_) : 0.0;
  initial_internal_ = std::asinh(p.preconsolidation_pressure / moduli_.bulk()) / xi_;
}

double CamClay::preconsolidation_pressure(double internal) const { return moduli_.bulk() * std::sinh(xi_ * max(internal, 0.0)); }

double CamClay::yield_function(const MaterialState<double>& state) const {
  const double p = -trace(state.stress) / 3.0, q2 = 1.5 * norm2(deviator(state.stress)), p_c = preconsolidation_pressure(state.internal);
  return q2 * (1.0 + 2.0 * beta_) + slope_ * slope_ * (p + beta_ * p_c) * (p - p_c);
}

double CamClay::Parameters::critical_state_ratio() const {
  return (1.0 + cohesion_beta) / ((1.0 - cohesion_beta) * std::sqrt(1.0 + 2.0 * cohesion_beta)) * critical_state_slope;
}

double CamClay::Parameters::internal_friction() const {
  constexpr double vertical = 3.0;  // M' at which phi' is 90 degrees
  const double ratio = critical_state_ratio();
  return ratio < vertical ? std::tan(friction_angle(ratio)) : std::numeric_limits<double>::infinity();
}

// The scalar path for a trial state on which the fast path did not settle. In dilation it first isolates the root nearest to the trial
// state by exclusion: on [D_1, D_2] there is none if the least q of the flow rule exceeds the largest q of the surface,
//   Q |Y(D_2)| > m sqrt(max(v_1, v_2) e_1) (|Y_1| + c D_2)       (|Y|, e fall, v is convex).
// Intervals are walked from D = 0, halved where the test is not conclusive, down to 2^-20 of the range: two roots closer than that are
// ignored.
CamClay::Return<double> CamClay::return_map_by_exclusion(double p_trial, double q2, double x_n) const {
  if (!std::isfinite(p_trial + q2 + x_n)) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  using Value = Residual<double>::Value;
  const Residual<double> residual(*this, p_trial, q2, x_n, std::sinh(xi_ * max(x_n, 0.0)));
  const double reach = residual.reach(x_n);
  const auto is_beyond = [&](const Value& value) { return !(residual.excess(value) > 0.0 && value.y * residual.side > 0.0); };
  double near = 0.0, far = residual.side * reach;

  if (residual.side < 0.0 && m2_ > 0.0) {
    const double least_width = reach * 0x1p-20;
    double width = reach, d1 = 0.0;
    Value at1 = residual(0.0);
    bool isolated = false;
    while (d1 < reach && !isolated) {
      const double d2 = min(d1 + width, reach);
      const Value at2 = residual(-d2);
      const double flow = max(-at2.y, 0.0), most = max(-at1.y, 0.0) + c_ * d2;
      const double surface2 = m2_ * max(max(at1.v, at2.v), 0.0) * max(at1.e, 0.0);
      const bool excluded = at2.y < 0.0 && (surface2 == 0.0 || q2 * flow * flow > surface2 * most * most);
      if (!excluded && width > least_width) {
        width *= 0.5;
        continue;
      }
      if (!excluded && is_beyond(at2)) {
        near = -d1, far = -d2, isolated = true;
      } else {
        if (excluded) width *= 2.0;
        d1 = d2, at1 = at2;
      }
    }
    if (!isolated) return {p_trial, 0.0};  // no strength left: p = q = p_c = 0
  }

  // Newton inside the bracket, with a bisection every third time so that it always closes (about 60 bisections span a double's precision,
  // 40 more the range of small roots).
  double x = near;
  Value value = residual(x);
  for (int iteration = 0; iteration < 600; ++iteration) {
    (is_beyond(value) ? far : near) = x;
    const double newton = x + residual.newton(value, x).step();
    const bool within = value.y * residual.side > 0.0 && (newton - near) * (newton - far) <= 0.0;
    const double next = within && iteration % 3 != 2 ? newton : 0.5 * (near + far);
    const bool settled = abs(next - x) <= 2.0 * std::numeric_limits<double>::epsilon() * abs(next);
    x = next;
    value = residual(x);
    if (settled) break;
  }
  return {residual.d_base + x, m2_ > 0.0 ? value.y / value.w : 0.0};
}

}  // namespace mpm
