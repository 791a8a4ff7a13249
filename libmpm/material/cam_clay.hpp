#pragma once
/// Cohesive Modified Cam-Clay (cMCC) of the paper, Sect. 2.1.2, after Gaume et al. (2018), with the return map for every trial state.
///
/// Textbook form. Elastic: Hencky (hencky_elastic.hpp); p = -tr(tau)/3, q = sqrt(3/2 s:s), Kirchhoff.
///   yield      y = q^2 (1 + 2 beta) + M^2 (p + beta p_c)(p - p_c) <= 0                                   (Eq. 3)
///   hardening  p_c = K sinh(xi max(X, 0)), X = -eps_v^P                                                   (Eq. 4)
///   flow       L_v b_e = -2 gamma N b_e, N = dy/dtau (associative; Simo & Meschke 1993)
/// Backward Euler with the exponential map keeps the principal directions and gives, with g >= 0,
///   X = X_n + g y_p,  p = p_tr - K (X - X_n),  q = q_tr / (1 + 6 G (1 + 2 beta) g),  y(p, q, p_c(X)) = 0,  y_p = M^2 (2 p - (1 - beta)
///   p_c).
///
/// Form coded. Everything in units of K (P = p/K, Q = q_tr/K, S = p_c/K), one unknown d = X - X_n. With m^2 = M^2/(1 + 2 beta) (m is not
/// M'), Y = y_p / M^2 = 2 P - (1 - beta) S and c = 6 G / (K m^2), g K M^2 = d/Y, so that q = Q u with u = Y / (Y + c d), and the residual
/// is
///   A(d) = Q^2 u^2 + m^2 (P + beta S)(P - S),   P = P_tr - d,   S = sinh(xi max(X_n + d, 0)).
/// g >= 0 asks d and Y to have one sign, and Y(d) decreases, so the sign of Y at the trial state determines the side:
///
/// Compaction (Y >= 0, d in [0, d_crit], Y(d_crit) = 0, d_crit <= P_tr). u decreases with d and
///   d/dd [(P + beta S)(P - S)] = -Y - S' [(1 - beta) P + 2 beta S] < 0,
/// so A falls monotonically from y_tr > 0 to -m^2 (1 + beta)^2/4 S^2 <= 0: one root. If X_n < 0 there is no resistance until X = 0; the
/// search starts there, and if already X_n + P_tr <= 0 the point is stress-free at X = X_n + P_tr.
///
/// Dilation (Y < 0, D = -d in [0, D_crit]). The surface shrinks while the point is returned, and A can have several roots, or none
/// (snap-back). Wanted is the nearest. With v = P + beta S, e = S - P, a root is where
///   ln Q = 1/2 ln(m^2 v) + 1/2 ln e + ln(1 + c D/|Y|),
/// v convex in D, e and |Y| convex and falling. The root found at D_r is the nearest if the right side rises on all of [0, D_r]; each of
/// its slopes is bounded there, with S' taken at D = 0 where it is largest:
///   third  >= c / (|Y_0| + c D_r)
///   second >= -1/2 (1 + S'_0) / e_r
///   first  >= 1/2 (1 - beta S'_0) / v_r if beta S'_0 <= 1, else -1/2 (beta S'_0 - 1) / (v_0 - (beta S'_0 - 1) D_r) if that denominator is
///   positive.
/// Where the sum of bounds is not positive, a search by exclusion (below, scalar) isolates the first root rigorously.
/// Without a root the point loses all stress: p = q = p_c = 0 at X = X_n + P_tr <= 0. For q = 0 both rules give the root
/// X < X_n of X - beta sinh(xi max(X, 0)) = X_n + P_tr: that function is concave and above its target at X_n, so the root is unique.
///
/// M = 0 is the limit M -> 0+: q = 0 and p in [-beta p_c, p_c] with X unchanged; beyond, P = S or P = -beta S is solved.
///
/// Precision: S and Y are carried as increments from the trial state, so that small steps keep relative precision; the deviator is scaled
/// by u.

#include <string_view>

#include "libmpm/material/concept.hpp"
#include "libmpm/material/hencky_elastic.hpp"

namespace mpm {

/// The law; formulas above.
class CamClay {
 public:
  /// Elastic moduli and the yield surface with its hardening.
  struct Parameters : HenckyModuli::Parameters {
    static constexpr std::string_view name = "cohesive_cam_clay";  ///< value of [material] model
    /// One line for the reference of keys.
    static constexpr std::string_view description =
        "Cohesive Modified Cam-Clay: yield q^2 (1 + 2 beta) + M^2 (p + beta p_c)(p - p_c), p_c = K sinh(xi X)";
    /// The law in formulas, for exported cases.
    static constexpr std::string_view equations =
        "Hencky elasticity (tau = K tr(eps) I + 2 G dev(eps), eps = 1/2 ln b_e) with the yield surface q^2 (1 + 2 beta) + M^2 "
        "(p + beta p_c)(p - p_c) <= 0 in the Kirchhoff stress, p = -tr(tau)/3, q = sqrt(3/2 s:s), associative flow, p_c = K "
        "sinh(xi max(X, 0)), X = -(plastic volume strain), X_0 = asinh(p_c0/K)/xi; sigma = tau/J. M = 0: no shear stress, p in "
        "[-beta p_c, p_c]. internal: X.";
    static constexpr bool keeps_compaction = true;  ///< compacted snow stays denser and harder

    double critical_state_slope = 0.4;         ///< M
    double cohesion_beta = 0.0;                ///< beta = p_t / p_c
    double hardening_xi = 5.0;                 ///< xi
    double preconsolidation_pressure = 1.0e4;  ///< p_c0, Pa
    bool operator==(const Parameters&) const = default;

    /// M' = q/p at the critical state, Eq. 2 of the paper.
    [[nodiscard]] double critical_state_ratio() const;
    /// phi' = asin(3 M' / (M' + 6)), rad (text below Eq. 2). @param ratio  M', at most 3
    [[nodiscard]] static double friction_angle(double ratio) { return std::asin(3.0 * ratio / (ratio + 6.0)); }
    /// tan(phi'); infinite from M' = 3 on, where phi' is 90 degrees.
    [[nodiscard]] double internal_friction() const;

    /// The keys (base/parameter.hpp).
    template <class Table>
    static void declare(Table& table) {
      HenckyModuli::Parameters::declare(table);
      table.add("critical_state_slope", &Parameters::critical_state_slope)
          .range(0.0, 10.0)
          .required()
          .text("Slope M of the critical state line; 0 is an inviscid fluid");
      table.add("cohesion_beta", &Parameters::cohesion_beta)
          .below(0.0, 1.0)
          .required()
          .text("Cohesion beta = tensile over compressive isotropic strength; at 1 the critical state would bear no pressure");
      table.add("hardening_xi", &Parameters::hardening_xi)
          .range(2e-3, 1e3)
          .required()
          .text("Hardening factor xi; large: hardly compressible");
      table.add("preconsolidation_pressure_pa", &Parameters::preconsolidation_pressure)
          .unit("Pa")
          .range(1e-3, 1e9)
          .text("Initial pre-consolidation pressure p_c0");
    }
  };

  /// Beside what every law has.
  static constexpr OptionalMembers has{.try_update_stress = true,
                                       .expect_single_states = true,
                                       .yield_function = true,
                                       .preconsolidation_pressure = true,
                                       .internal_friction = true,
                                       .critical_state_ratio = true,
                                       .hardening_xi = true,
                                       .cohesion_beta = true,
                                       .keeps_compaction = true};

  /// @throws ConfigError if a parameter is out of range
  explicit CamClay(const Parameters& parameters);

  /// Backward Euler step. state.internal is X = -eps_v^P. The result is NaN in a lane whose deformation is inverted or not finite.
  template <LaneNumber T>
  void update_stress(MaterialState<T>& state, const Matrix3<T>& dl, double /*dt*/) const {
    (void)update(state, dl);
  }
  /// The same in single precision. Returns false and leaves the state unchanged if that does not suffice: if a point yields near an apex
  /// of the surface, if its root is not shown to be the nearest, or if M = 0.
  bool try_update_stress(MaterialState<SinglePair>& state, const Matrix3<SinglePair>& dl, double /*dt*/) const {
    MaterialState<SinglePair> updated = state;
    if (!update(updated, dl)) return false;
    state = updated;
    return true;
  }
  /// Declares that states are rounded to single precision between steps: a point outside the surface by round-off does not yield.
  void expect_single_states() { round_off_ = 1e-6; }

  /// J = det F = exp(tr eps_e + X_0 - X), relative to the initial state.
  template <LaneNumber T>
  [[nodiscard]] T volume_ratio(const MaterialState<T>& state) const {
    return exp(trace(state.stress) * (1.0 / (3.0 * moduli_.bulk())) + (initial_internal_ - state.internal));
  }
  [[nodiscard]] double density() const { return moduli_.density(); }           ///< rho_0, kg/m^3
  [[nodiscard]] double initial_internal() const { return initial_internal_; }  ///< X_0 = asinh(p_c0/K)/xi
  [[nodiscard]] double wave_speed() const { return moduli_.wave_speed(); }     ///< c_P, m/s
  [[nodiscard]] double bulk_speed() const { return moduli_.bulk_speed(); }     ///< sqrt(K/rho_0), m/s
  [[nodiscard]] double stored_energy(const MaterialState<double>& state) const {
    return moduli_.stored_energy(state.stress);
  }                                                                     ///< elastic, J/m^3 of reference volume
  [[nodiscard]] const HenckyModuli& moduli() const { return moduli_; }  ///< the elastic part

  /// p_c = K sinh(xi max(X, 0)), Pa.
  [[nodiscard]] double preconsolidation_pressure(double internal) const;
  /// y of Eq. 3, Pa^2; <= 0 inside. For M = 0 too, where it does not bound p.
  [[nodiscard]] double yield_function(const MaterialState<double>& state) const;

 private:
  /// Result of the return map: d = X - X_n and u = q/q_tr.
  template <class T>
  struct Return {
    T d, u;
    bool settled = true;  ///< false: single precision does not suffice
  };
  /// @return false where single precision does not suffice; the state is then undefined
  template <LaneNumber T>
  bool update(MaterialState<T>& state, const Matrix3<T>& dl) const;

  /// The residual as a function of the offset x = d - d_base from the base state (the trial state, or X = 0 on the way of recompaction).
  template <class T>
  struct Residual {
    struct Value {
      T y, w, v, e;              // Y, Y + c d, P + beta S, S - P
      T s_slope, y_slope;        // dS/dx, dY/dx
      T surface, surface_slope;  // m^2 (P + beta S)(S - P), equal to Q^2 u^2 at a root, and its slope
    };
    struct Newton {
      T numerator, denominator;
      [[nodiscard]] T step() const { return -numerator / denominator; }
    };
    /// Result of a search: x, Y there, and P + beta S and S - P before the last step.
    struct Root {
      T x, y, v, e;
    };
    /// @param s_trial  S at the trial state (X = X_n)
    Residual(const CamClay& law, const T& p_trial, const T& q2, const T& x_n, const T& s_trial);
    /// Largest |x| at which a root can lie.
    [[nodiscard]] T reach(const T& x_n) const;
    /// At the base itself, x = 0.
    [[nodiscard]] Value at_base() const { return evaluate(T{}, T{}, law_.xi_ * cosh); }
    [[nodiscard]] Value operator()(const T& x) const;
    /// Positive between the base and the nearest root: sign of A; M = 0: excess of P over its bound.
    [[nodiscard]] T excess(const Value& at) const;
    /// Where u is not near an apex of the surface: q above 35 % of the surface's height.
    [[nodiscard]] Mask<T> interior(const Value& at) const;
    /// From sqrt(surface) (Q Y - sqrt(surface) w), in which Y and w are nearly linear: good in the interior.
    [[nodiscard]] Newton interior_newton(const Value& at) const;
    /// Valid everywhere: near an apex from A itself (times w^3).
    [[nodiscard]] Newton newton(const Value& at, const T& x) const;
    /// A lane is settled when its step is so small that, the convergence being quadratic (the next step is about step^3 / previous^2), the
    /// next one would be below round-off; Y at the new x then follows from its slope. @param x  new offset; @param width  (1 + beta) S.
    /// In double precision x is found to its own relative precision, in single precision to that of the surface, to which X is rounded.
    [[nodiscard]] static Mask<T> is_settled(const T& size, const T& previous, const T& x, const T& width) {
      if constexpr (is_single<T>) return (size <= 3e-3 * width) & (size * size * size <= 1e-7 * width * previous * previous);
      const T scale = min(abs(x), width);
      return (size <= 1e-8 * scale) | ((size <= 1e-6 * scale) & (size * size * size <= 1e-16 * scale * previous * previous));
    }
    /// Inside the surface Newton's method converges without safeguards, in three or four steps: all lanes together; the results are
    /// checked afterwards. @return false, and no root, unless all lanes start inside and have a valid root
    [[nodiscard]] bool search_inside(const Value& base, const T& reach, const Mask<T>& wanted, Root& root) const;

    const CamClay& law_;
    T q2, q;                  // Q^2, Q
    T d_base, p, y, s, cosh;  // at the base: d, P, Y, S, sqrt(1 + S^2)
    T side;                   // +1 compaction, -1 dilation

   private:
    /// @param increment  S - S_base; @param s_slope  dS/dx
    [[nodiscard]] Value evaluate(const T& x, const T& increment, const T& s_slope) const;
  };

  template <class T>
  [[nodiscard]] Return<T> return_map(const T& p_trial, const T& q2, const T& x_n, const T& s_n, const Mask<T>& yields) const;
  [[nodiscard]] Return<double> return_map_by_exclusion(double p_trial, double q2, double x_n) const;

  /// A returned state is on the surface only to round-off, and must not yield again because of that, especially not at a tension apex,
  /// where it would snap back. The elastic domain is therefore larger by this fraction of p_c^2 (p_c if M = 0).
  double round_off_ = 1e-13;

  HenckyModuli moduli_;
  double slope_, beta_, xi_;  // M, beta, xi
  double m2_, c_;             // m^2, c; c = 0 where M = 0
  double initial_internal_;
};

template <class T>
inline CamClay::Residual<T>::Residual(const CamClay& law, const T& p_trial, const T& q2_trial, const T& x_n, const T& s_trial)
    : law_(law), q2(q2_trial), q(sqrt(q2_trial)), s(s_trial) {
  d_base = max(x_n, T{}) - x_n;  // S is the same at X_n < 0 and at the base X = 0
  p = p_trial - d_base;
  cosh = sqrt(1.0 + s * s);
  y = 2.0 * p - (1.0 - law.beta_) * s;
  side = select(y >= 0.0, broadcast<T>(1.0), broadcast<T>(-1.0));
  constexpr double tiny = by_precision<T>(1e-60, 1e-30);
  y = select(abs(y) < tiny, side * tiny, y);  // a trial state at the critical state: the ratio d/Y stays defined
}

template <class T>
inline T CamClay::Residual<T>::reach(const T& x_n) const {
  // Compaction: P >= 0. Dilation: |Y| falls by at least 2 D, and X >= 0.
  return select(side > 0.0, p, min(x_n, -0.5 * y));
}

/// sum_k h2^k / (2 k + first)!: sinh(h)/h for first = 1, (cosh(h) - 1)/h^2 for first = 2.
template <int terms, class T>
inline T sinh_series(const T& h2, int first) {
  T sum = broadcast<T>(detail::inverse_factorial(2 * (terms - 1) + first));
#pragma GCC unroll 8
  for (int k = terms - 2; k >= 0; --k) sum = detail::inverse_factorial(2 * k + first) + sum * h2;
  return sum;
}

template <class T>
inline __attribute__((always_inline)) typename CamClay::Residual<T>::Value CamClay::Residual<T>::operator()(const T& x) const {
  // sinh(a + h) - sinh a = sinh a (cosh h - 1) + cosh a sinh h, relative precision for small h.
  const T h = law_.xi_ * x, h2 = h * h;
  T sinh_h, cosh_h_1;
  if (all(h2 <= 0.0025)) [[likely]] {  // truncated at 0.05^8/9! = 1e-16, and 2 * 0.05^8/10! = 2e-17
    sinh_h = h * sinh_series<by_precision<T>(4, 2)>(h2, 1);
    cosh_h_1 = h2 * sinh_series<by_precision<T>(4, 2)>(h2, 2);
  } else if (all(h2 <= 0.25)) {  // truncated at 0.5^14/15! = 5e-17, and 2 * 0.5^14/16! = 6e-18
    sinh_h = h * sinh_series<by_precision<T>(7, 4)>(h2, 1);
    cosh_h_1 = h2 * sinh_series<by_precision<T>(7, 4)>(h2, 2);
  } else {
    sinh_h = sinh(h);
    const T half = sinh(0.5 * h);
    cosh_h_1 = 2.0 * half * half;
  }
  return evaluate(x, s * cosh_h_1 + cosh * sinh_h, law_.xi_ * (cosh + (cosh * cosh_h_1 + s * sinh_h)));
}

template <class T>
inline __attribute__((always_inline)) typename CamClay::Residual<T>::Value CamClay::Residual<T>::evaluate(const T& x, const T& increment,
                                                                                                          const T& s_slope) const {
  const double beta = law_.beta_, m2 = law_.m2_, c = law_.c_;
  const T s_x = s + increment, p_x = p - x, d = d_base + x;
  Value r;
  r.s_slope = s_slope;
  r.y = y - 2.0 * x - (1.0 - beta) * increment;
  r.y_slope = -2.0 - (1.0 - beta) * s_slope;
  r.v = p_x + beta * s_x;
  r.e = (s - p) + (x + increment);
  r.w = r.y + c * d;
  r.surface = m2 * (r.v * r.e);
  r.surface_slope = m2 * (r.y + s_slope * ((1.0 - beta) * p_x + (2.0 * beta) * s_x));
  return r;
}

template <class T>
inline T CamClay::Residual<T>::excess(const Value& at) const {
  if (law_.m2_ == 0.0) return select(side > 0.0, -at.e, -at.v);
  const T flow = q * at.y;
  return flow * flow - at.surface * (at.w * at.w);
}

template <class T>
inline Mask<T> CamClay::Residual<T>::interior(const Value& at) const {
  const T width = at.v + at.e;
  return at.v * at.e > 0.03 * (width * width);
}

template <class T>
inline typename CamClay::Residual<T>::Newton CamClay::Residual<T>::interior_newton(const Value& at) const {
  const T root = sqrt(max(at.surface, T{}));
  return {(q * at.y - root * at.w) * root, root * (q * at.y_slope - root * (at.y_slope + law_.c_)) - 0.5 * (at.w * at.surface_slope)};
}

template <class T>
inline typename CamClay::Residual<T>::Newton CamClay::Residual<T>::newton(const Value& at, const T& x) const {
  if (law_.m2_ == 0.0) {
    return {excess(at), select(side > 0.0, -1.0 - at.s_slope, 1.0 - law_.beta_ * at.s_slope)};
  }
  const Newton inside = interior_newton(at);
  const Mask<T> use_inside = interior(at);
  const T flow = q * at.y, w2 = at.w * at.w;
  return {select(use_inside, inside.numerator, excess(at) * at.w),
          select(use_inside, inside.denominator,
                 2.0 * law_.c_ * (q * flow) * (at.y_slope * (d_base + x) - at.y) - at.surface_slope * (w2 * at.w))};
}

template <class T>
inline __attribute__((always_inline)) bool CamClay::Residual<T>::search_inside(const Value& base, const T& reach, const Mask<T>& wanted,
                                                                               Root& root) const {
  constexpr int least = by_precision<T>(3, 2), most = by_precision<T>(6, 5);
  if (!all(interior(base) | mask_not(wanted))) return false;
  Value at = base;
  T x = T{}, previous = abs(reach);
  for (int steps = 1;; ++steps) {
    const T step = interior_newton(at).step(), size = abs(step);
    x += step;
    if (steps >= least) {
      const T y_there = at.y + at.y_slope * step;
      const Mask<T> sound = is_settled(size, previous, x, at.v + at.e) & interior(at) & (y_there * side > 0.0) & (x * (reach - x) >= 0.0);
      if (all(sound | mask_not(wanted))) {
        root = {x, y_there, at.v, at.e};
        return true;
      }
      if (steps == most) return false;
    }
    previous = size;
    at = (*this)(x);
  }
}

// In one piece: the base, the search inside the surface and Newton's iteration share five masks and the bracket of every lane, which parts
// would hand to each other as one large struct. Not inlined: beside it the elastic path would have no registers left.
template <class T>
__attribute__((noinline)) CamClay::Return<T> CamClay::return_map(const T& p_trial, const T& q2, const T& x_n, const T& s_n,
                                                                 const Mask<T>& yields) const {
  constexpr int most_iterations = 15;
  const Mask<T> stress_free = x_n + p_trial <= 0.0;
  Mask<T> lost = yields & stress_free & (x_n <= 0.0);  // stays expanded: no root to search
  Mask<T> active = yields & mask_not(lost);
  Return<T> result{select(lost, p_trial, T{}), select(yields, T{}, broadcast<T>(1.0))};
  if (!any(active)) return result;
  if constexpr (is_single<T>) {
    if (m2_ == 0.0) return {result.d, result.u, false};
  }

  const Residual<T> residual(*this, p_trial, q2, x_n, s_n);
  typename Residual<T>::Value value = residual.at_base();
  const T v_0 = value.v, slope_0 = value.s_slope;
  Mask<T> found = active & mask_not(active);
  if (m2_ == 0.0) {
    const Mask<T> outside = residual.excess(value) > round_off_ * residual.s;
    found = active & mask_not(outside);  // p is within its bounds: only q vanishes
    lost = lost | (active & outside & stress_free);
    active = active & outside & mask_not(stress_free);
    result.d = select(lost, p_trial, T{});
  }
  const T reach = residual.side * residual.reach(x_n);
  typename Residual<T>::Root root{T{}, residual.y, value.v, value.e};
  if (m2_ != 0.0 && residual.search_inside(value, reach, active, root)) {
    found = active;
    active = active & mask_not(active);
  }
  if constexpr (is_single<T>) {
    if (any(active)) return {result.d, result.u, false};
  }

  // Safeguarded Newton.
  T near = T{}, far = reach, previous = abs(reach);
  for (int iteration = 0; iteration < most_iterations && any(active); ++iteration) {
    const Mask<T> same_side = value.y * residual.side > 0.0;  // else past the critical state, where A has inadmissible roots
    const Mask<T> beyond = mask_not((residual.excess(value) > 0.0) & same_side);
    near = select(beyond, near, root.x);
    far = select(beyond, root.x, far);
    const T newton = root.x + residual.newton(value, root.x).step();
    // A correction of the size of round-off is accepted even outside the bracket, whose ends have round-off, too.
    const Mask<T> minute = abs(newton - root.x) <= 1e-9 * abs(root.x);
    const Mask<T> within = same_side & (((newton - near) * (newton - far) <= 0.0) | minute);
    const T next = select(within, newton, 0.5 * (near + far));
    const T step = next - root.x, size = abs(step);
    const Mask<T> settled = active & within & residual.is_settled(size, previous, next, value.v + value.e);
    root.y = select(settled, value.y + value.y_slope * step, root.y);
    root.v = select(settled, value.v, root.v);
    root.e = select(settled, value.e, root.e);
    previous = size;
    root.x = select(active, next, root.x);
    found = found | settled;
    active = active & mask_not(settled);
    if (!any(active)) break;
    value = residual(root.x);
  }
  const T d = residual.d_base + root.x;
  if (m2_ != 0.0) {
    // Compaction has one root. In dilation the root must be shown to be the nearest.
    // The sum of the three bounds (see above), times their denominators.
    const T softening = beta_ * slope_0 - 1.0;
    const T first = select(softening <= 0.0, root.v, v_0 + softening * root.x), third = -residual.y - c_ * root.x;  // x = -D
    const T rise = c_ * first * root.e - 0.5 * third * (softening * root.e + (1.0 + slope_0) * first);
    found = found & ((residual.side > 0.0) | ((first > 0.0) & (root.e > 0.0) & (rise > 0.0)));
    result.u = select(found, root.y / (root.y + c_ * d), result.u);
  }
  result.d = select(found, d, result.d);
  const Mask<T> open = yields & mask_not(lost) & mask_not(found);
  if (any(open)) {
    if constexpr (is_single<T>) return {result.d, result.u, false};
    const T flag = select(open, broadcast<T>(1.0), T{});
    for (int i = 0; i < lanes_of<T>; ++i) {
      if (lane(flag, i) == 0.0) continue;
      const Return<double> r = return_map_by_exclusion(lane(p_trial, i), lane(q2, i), lane(x_n, i));
      set_lane(result.d, i, r.d);
      set_lane(result.u, i, r.u);
    }
  }
  return result;
}

template <LaneNumber T>
bool CamClay::update(MaterialState<T>& state, const Matrix3<T>& dl) const {
  const double shear_over_bulk = moduli_.shear() / moduli_.bulk();
  HenckyStrain<T> strain = hencky_trial(moduli_.strain(state.stress), dl);
  const T p = -strain.volumetric;
  const T q2 = (6.0 * shear_over_bulk * shear_over_bulk) * norm2(strain.deviator);
  const T s = sinh(xi_ * max(state.internal, T{}));
  const T excess =
      m2_ == 0.0 ? max(max(p - s, -p - beta_ * s) - round_off_ * s, q2) : q2 + m2_ * ((p + beta_ * s) * (p - s) - round_off_ * s * s);
  const Mask<T> yields = excess > 0.0;
  if (any(yields)) {
    const Return<T> r = return_map<T>(p, q2, state.internal, s, yields);
    if (!r.settled) return false;
    strain.volumetric += r.d;
    strain.deviator = r.u * strain.deviator;
    state.internal += r.d;
  }
  state.stress = moduli_.stress(strain);
  return true;
}

static_assert(Material<CamClay>);

}  // namespace mpm
