#pragma once
/// Drained expansion of a cylindrical cavity in Modified Cam-Clay, large strain, plane strain: the equations of Chen & Abousleiman (2013)
/// for the law of the library (Hencky elasticity, p_c = K sinh(xi X)), derived anew. Nothing of the library's own law is used here.
///
/// A cavity that grows from nothing in an endless medium has no length but its own radius, so that every state depends on r over that
/// radius only; hence along the path of a particle, and along a radius at one time, states run through the same one-parameter family. Its
/// parameter is the hoop strain s = ln(r/R). A cavity that grows from a radius a is the part R >= a of this solution: the motion of R = a
/// starts at s = 0 and is monotone, and the law does not depend on the rate.
///
/// With lambda = r/R = e^s, mu = dr/dR, m = d ln mu/ds and rho = mu/lambda, equilibrium d(tau_r/mu)/dR + (tau_r/mu - tau_theta/lambda)/R =
/// 0 and d lambda/dR = (mu - lambda)/R give
///   (rho - 1)(d tau_r/ds - m tau_r) + tau_r - rho tau_theta = 0,      d ln R/ds = 1/(rho - 1).
/// The strain rates by s are (m, 1, 0) along r, theta, z; with y = q^2 (1 + 2 beta) + M^2 (p + beta p_c)(p - p_c), N = dy/dtau and the
/// elastic stiffness C
///   d eps^e/ds = (m, 1, 0) - g N,  g = N:C:(m, 1, 0)/D,  D = N:C:N + M^2 ((1 - beta) p + 2 beta p_c) y_p H,  dX/ds = g y_p,
/// H = dp_c/dX = xi sqrt(K^2 + p_c^2), so that d tau_r/ds = A m + B and m follows. CVODE integrates from s = 1e-6, where the field is that
/// of Lame, eps_r = -eps_theta.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libmpm/base/error.hpp"
#include "validation/harness/ode_reference.hpp"
#include "validation/harness/radial_field.hpp"
#include "validation/harness/sundials.hpp"

namespace mpm::validation {

/// One member of the family of states.
struct SimilarState {
  double place = 0.0;                                                              ///< L = ln R + const
  double strain = 0.0;                                                             ///< s
  double radial_strain = 0.0, slope = 0.0;                                         ///< ln mu, m
  double radial = 0.0, hoop = 0.0, axial = 0.0;                                    ///< Kirchhoff stress, Pa
  double internal = 0.0;                                                           ///< X
  double p = 0.0, q = 0.0;                                                         ///< Pa
  [[nodiscard]] double ratio() const { return std::exp(radial_strain - strain); }  ///< rho
};

/// The family from s = 1e-6 to a largest hoop strain.
class CavityExpansion {
 public:
  /// @param pressure  isotropic, in situ, compression positive, Kirchhoff, Pa; inside the yield surface, on its compactive side
  /// @param plastic  false: elastic, for the comparison with Lame's solution
  CavityExpansion(const CamClay& model, double pressure, double largest_strain, bool plastic = true) : m_(model), pressure_(pressure) {
    Unknowns y{-first,
               -pressure / (3.0 * m_.bulk_modulus) - first,
               -pressure / (3.0 * m_.bulk_modulus) + first,
               -pressure / (3.0 * m_.bulk_modulus),
               m_.initial_internal(),
               0.0};
    bool yields = false;
    OdeIntegrator ode(
        y.size(), [&](double t, const double* state, double* dydt) { rates(std::exp(t), state, yields, dydt); }, 1e-11, 1e-15);
    const auto surface = [this](double, const double* state, double* g) {
      const Stress s = stress(state);
      g[0] = m_.yield(s.p, s.q, state[4]) / (m_.preconsolidation_pressure * m_.preconsolidation_pressure);
    };
    const double begin = std::log(first), end = std::log(largest_strain);
    const auto watch = [&](double from) {  // the end of elasticity is a root
      if (yields || !plastic) {
        ode.start(from, y, end, {}, {});
      } else {
        ode.start(from, y, end, surface, {1});
      }
    };
    watch(begin);
    keep(begin, y, yields);
    for (int i = 1; i <= samples;) {
      const double target = i == samples ? end : begin + (end - begin) * i / samples;
      const OdeIntegrator::Stop stop = ode.advance(target);
      std::ranges::copy(ode.state(), y.begin());
      if (stop.root < 0) {
        keep(target, y, yields);
        ++i;
        continue;
      }
      keep(stop.time, y, false);
      onset_ = std::exp(stop.time);
      yields = true;
      watch(stop.time);
      keep(stop.time, y, true);
    }
  }

  [[nodiscard]] double onset() const { return onset_; }                              ///< s at which yielding begins
  [[nodiscard]] const std::vector<SimilarState>& states() const { return states_; }  ///< s rising
  /// J of the start.
  [[nodiscard]] double initial_volume_ratio() const { return std::exp(-pressure_ / m_.bulk_modulus); }

  /// The state at a place L; linear between neighbours but for s, whose slope is known.
  [[nodiscard]] SimilarState at(double place) const {
    const SimilarState& far = states_.front();
    if (place >= far.place) {  // Lame: the strain falls as R^-2
      const double s = far.strain * std::exp(-2.0 * (place - far.place));
      SimilarState r = far;
      r.place = place, r.strain = s, r.radial_strain = -s, r.slope = -1.0;
      r.radial = -pressure_ - 2.0 * m_.shear_modulus * s, r.hoop = -pressure_ + 2.0 * m_.shear_modulus * s;
      return r;
    }
    const auto above =
        std::lower_bound(states_.begin() + 1, states_.end() - 1, place, [](const SimilarState& a, double x) { return a.place > x; });
    const SimilarState &a = *(above - 1), &b = *above;
    const double width = b.place - a.place, u = width == 0.0 ? 1.0 : (place - a.place) / width;
    const auto between = [&](double SimilarState::*what) { return a.*what + u * (b.*what - a.*what); };
    SimilarState r;
    r.place = place;
    const double slope_a = width * (a.ratio() - 1.0), slope_b = width * (b.ratio() - 1.0), rise = b.strain - a.strain;
    r.strain = a.strain + u * (slope_a + u * (3.0 * rise - 2.0 * slope_a - slope_b + u * (slope_a + slope_b - 2.0 * rise)));
    r.radial_strain = between(&SimilarState::radial_strain), r.slope = between(&SimilarState::slope);
    r.radial = between(&SimilarState::radial), r.hoop = between(&SimilarState::hoop), r.axial = between(&SimilarState::axial);
    r.internal = between(&SimilarState::internal), r.p = between(&SimilarState::p), r.q = between(&SimilarState::q);
    return r;
  }
  /// L at a hoop strain.
  [[nodiscard]] double place_of(double strain) const {
    const SimilarState& far = states_.front();
    if (strain <= far.strain) return far.place - 0.5 * std::log(strain / far.strain);
    double low = states_.back().place, high = far.place;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (at(middle).strain > strain ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  /// A cavity of the radius a whose hoop strain grows to `strain` in `duration`, smoothly: 10 x^3 - 15 x^4 + 6 x^5.
  [[nodiscard]] RadialMotion motion(double inner, double strain, double duration) const {
    return [this, inner, strain, duration](double time) -> RadialState {
      const double x = std::clamp(time / duration, 0.0, 1.0);
      const double s = strain * x * x * x * (10.0 + x * (6.0 * x - 15.0));
      const double rate = strain * 30.0 * x * x * (1.0 - x) * (1.0 - x) / duration;
      const double growth = strain * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (duration * duration);
      if (s < 1e-12) {
        return [this](double radius) {
          RadialPoint r;
          r.r = radius;
          r.radial = r.hoop = r.axial = -pressure_;
          r.internal = m_.initial_internal();
          return r;
        };
      }
      // L of a particle is that of the cavity, which falls with time, plus ln(R/a)
      const double cavity = place_of(s);
      const SimilarState wall = at(cavity);
      const double shift = rate / first_slope(wall);
      const double shift_rate = (growth - second_slope(wall) * shift * shift) / first_slope(wall);
      return [this, inner, cavity, shift, shift_rate](double radius) {
        const SimilarState now = at(cavity + std::log(radius / inner));
        const double s_rate = first_slope(now) * shift, s_growth = second_slope(now) * shift * shift + first_slope(now) * shift_rate;
        RadialPoint r;
        r.r = radius * std::exp(now.strain);
        r.velocity = r.r * s_rate;
        r.acceleration = r.r * (s_rate * s_rate + s_growth);
        r.hoop_rate = s_rate;
        r.radial_rate = now.slope * s_rate;
        r.radial = now.radial, r.hoop = now.hoop, r.axial = now.axial;
        r.internal = now.internal;
        return r;
      };
    };
  }

 private:
  static constexpr double first = 1e-6;  ///< s at the start; the elastic strains of yielding are a thousand times larger
  static constexpr int samples = 20000;
  /// ds/dL and d2s/dL2.
  static double first_slope(const SimilarState& a) { return a.ratio() - 1.0; }
  static double second_slope(const SimilarState& a) { return a.ratio() * (a.slope - 1.0) * (a.ratio() - 1.0); }
  using Unknowns = std::array<double, 6>;  ///< ln mu, elastic strains r, theta, z, X, L

  struct Stress {
    std::array<double, 3> tau, deviator;
    double p, q;
  };
  [[nodiscard]] Stress stress(const double* y) const {
    const double volumetric = y[1] + y[2] + y[3], mean = m_.bulk_modulus * volumetric;
    Stress s{};
    double norm = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      s.deviator[i] = 2.0 * m_.shear_modulus * (y[1 + i] - volumetric / 3.0);
      s.tau[i] = s.deviator[i] + mean;
      norm += s.deviator[i] * s.deviator[i];
    }
    s.p = -mean;
    s.q = std::sqrt(1.5 * norm);
    return s;
  }
  struct Flow {
    std::array<double, 3> normal{};  ///< N
    double multiplier = 0.0;         ///< g
    double y_p = 0.0, slope = 0.0;   ///< of the yield function; m
  };
  [[nodiscard]] Flow flow(double strain, const double* y, bool yields) const {
    const Stress s = stress(y);
    const double bulk = m_.bulk_modulus, shear = m_.shear_modulus, ratio = std::exp(y[0] - strain);
    double a = bulk + 4.0 / 3.0 * shear, b = bulk - 2.0 / 3.0 * shear;
    Flow f;
    std::array<double, 3> driven{};  // C N
    double resistance = 1.0;         // D
    if (yields) {
      const double pc = m_.preconsolidation(y[4]), m2 = m_.critical_state_slope * m_.critical_state_slope, beta = m_.cohesion_beta;
      f.y_p = m2 * (2.0 * s.p - (1.0 - beta) * pc);
      const double hardening = m_.hardening_xi * std::hypot(bulk, pc);
      resistance = m2 * ((1.0 - beta) * s.p + 2.0 * beta * pc) * f.y_p * hardening;
      for (std::size_t i = 0; i < 3; ++i) {
        f.normal[i] = 3.0 * (1.0 + 2.0 * beta) * s.deviator[i] - f.y_p / 3.0;
        driven[i] = 6.0 * (1.0 + 2.0 * beta) * shear * s.deviator[i] - bulk * f.y_p;
        resistance += f.normal[i] * driven[i];
      }
      a -= driven[0] * driven[0] / resistance;
      b -= driven[0] * driven[1] / resistance;
    }
    f.slope = (-(s.tau[0] - ratio * s.tau[1]) / (ratio - 1.0) - b) / (a - s.tau[0]);
    if (yields) f.multiplier = (driven[0] * f.slope + driven[1]) / resistance;
    if (yields && !(f.multiplier > 0.0 && resistance > 0.0))
      throw UnstableError("cavity_expansion: the snow unloads or softens too fast; the family of states ends");
    return f;
  }
  /// By ln s.
  void rates(double strain, const double* y, bool yields, double* dydt) const {
    const Flow f = flow(strain, y, yields);
    const std::array<double, 3> total = {f.slope, 1.0, 0.0};
    dydt[0] = strain * f.slope;
    for (std::size_t i = 0; i < 3; ++i) dydt[1 + i] = strain * (total[i] - f.multiplier * f.normal[i]);
    dydt[4] = strain * f.multiplier * f.y_p;
    dydt[5] = strain / (std::exp(y[0] - strain) - 1.0);
  }
  void keep(double log_strain, const Unknowns& y, bool yields) {
    const double strain = std::exp(log_strain);
    const Stress s = stress(y.data());
    states_.push_back({y[5], strain, y[0], flow(strain, y.data(), yields).slope, s.tau[0], s.tau[1], s.tau[2], y[4], s.p, s.q});
  }

  CamClay m_;
  double pressure_, onset_ = 0.0;
  std::vector<SimilarState> states_;
};

}  // namespace mpm::validation
