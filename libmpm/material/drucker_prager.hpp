#pragma once
/// Drucker-Prager plasticity with a friction and a dilatancy angle on Hencky elasticity, for sand and other grains.
///
/// Textbook form. Elastic: Hencky (hencky_elastic.hpp); p = -tr(tau)/3, q = sqrt(3/2 s:s), Kirchhoff.
///   yield  f = q - A p - C <= 0            flow  d eps^P = dg (3/2 s/q + A_psi/3 I), dg = sqrt(2/3 dev eps^P : dev eps^P)
/// The cone is circular, the Mohr-Coulomb hexagon is not: the two agree on one kind of test, which `cone_matching` names (phi, c, psi of
/// Mohr-Coulomb):
///   triaxial_compression  A = 6 sin phi / (3 - sin phi),  C = 6 c cos phi / (3 - sin phi),  A_psi = 6 sin psi / (3 - sin psi)
///   plane_strain          A = sin phi / D,  C = c cos phi / D,  D = sqrt((1 - A_psi^2/9)/3) + A_psi sin(phi)/9,
///                         A_psi = 3 sin psi / sqrt(3 + sin^2 psi); psi = 0: A = sqrt(3) sin phi. At failure, elastic increments are over,
///                         eps_2^P = 0 puts s_2 at -2/9 A_psi q (Drucker & Prager 1952 for psi = phi: A = 3 sin phi / sqrt(3 + sin^2 phi)).
///   simple_shear          A = sqrt(3) tan phi,  C = sqrt(3) c,  A_psi = sqrt(3) tan psi: tan phi is the ratio of shear to normal stress
///                         on the plane of steady shear at constant volume, sqrt(J2)/p, and the slope on which a layer is stable; the
///                         friction coefficient of mu(I). (With plane_strain that ratio is sin phi.)
///
/// Backward Euler with the exponential map keeps the principal directions: q = q_tr - d, p = p_tr + K A_psi d / (3 G), d = 3 G dg, so that
/// d = (q_tr - A p_tr - C) / (1 + K A A_psi/(3 G)). Where that takes more than q_tr the point is beyond the apex and returns to it exactly:
/// q = 0, p = -C/A.
///
/// Tearing. The internal variable is the plastic volume strain X = eps_v^P >= 0, so that J = exp(tr eps + X). A point at the apex that
/// expands further tears: X grows, at constant stress. A point whose mean stress is not compressive and that is compressed closes the gap
/// X before it carries pressure again (the volume correction of Klar et al. 2016 and Tampubolon et al. 2017, without which sprayed and
/// landed material swells). The gap closes free of pressure: the tension of a cohesive point relaxes elastically first, so that nothing
/// is gained by tearing and closing. Where shear would dilate a point into pressure while its gap is open, p = 0 and q = C, because the
/// grains have space. For psi > 0 the dilated volume is part of X: it is permanent under pressure, and a point that has lost all pressure
/// may be repacked to X = 0.
///
/// Rate dependence, mu(I) (Jop, Forterre & Pouliquen 2006): A grows from A to A_2 (that of limit_friction_angle) as
///   A(I) = A + (A_2 - A) / (I_0/I + 1),   I = gamma' d_g / sqrt(p/rho_s),   gamma' = sqrt(2 D^P:D^P) = sqrt(3) dg/dt,
/// isochoric (psi = 0), p <= 0 counts as rate-independent. With e = q_tr - A p - C and h = I_0 3 G dt sqrt(p/rho_s) / (sqrt(3) d_g) the
/// implicit update is a quadratic (Dunatunga & Kamrin 2015): (e - d)(h + d) = (A_2 - A) p d, d in [0, e], one such root.

#include <cstdint>
#include <optional>
#include <string_view>

#include "libmpm/material/concept.hpp"
#include "libmpm/material/hencky_elastic.hpp"

namespace mpm {

/// On which test the cone agrees with the Mohr-Coulomb angles; formulas above.
enum class ConeMatching : std::uint8_t { plane_strain, triaxial_compression, simple_shear };

/// The law; formulas above.
class DruckerPrager {
 public:
  /// Elastic moduli, cone and, where all four are given, the parameters of mu(I).
  struct Parameters : HenckyModuli::Parameters {
    static constexpr std::string_view name = "drucker_prager";  ///< value of [material] model
    /// One line for the reference of keys.
    static constexpr std::string_view description =
        "Drucker-Prager cone q = A p + C, dilatancy of its own, tears and recompacts; mu(I) rate dependence if its four keys are given";
    /// The law in formulas, for exported cases.
    static constexpr std::string_view equations =
        "Hencky elasticity with the yield surface q - A p - C <= 0 in the Kirchhoff stress and a plastic potential of slope "
        "A_psi; plane_strain: A = sin(phi)/D, C = c cos(phi)/D, D = sqrt((1 - A_psi^2/9)/3) + A_psi sin(phi)/9, A_psi = 3 "
        "sin(psi)/sqrt(3 + sin(psi)^2). A point at the apex that expands tears, and closes again before it carries pressure. "
        "internal: plastic volume strain.";

    ConeMatching cone_matching = ConeMatching::plane_strain;  ///< which A, C and A_psi follow from the angles
    double friction_angle = 0.5;                              ///< phi, rad
    double dilatancy_angle = 0.0;                             ///< psi, rad
    double cohesion = 0.0;                                    ///< c, Pa
    std::optional<double> limit_friction_angle;               ///< phi_2 of mu(I), rad; these four together or none
    std::optional<double> reference_inertial_number;          ///< I_0
    std::optional<double> grain_diameter;                     ///< d, m
    std::optional<double> grain_density;                      ///< rho_s, kg/m^3
    bool operator==(const Parameters&) const = default;

    [[nodiscard]] double internal_friction() const { return std::tan(friction_angle); }  ///< tan(phi)

    /// The keys (base/parameter.hpp).
    template <class Table>
    static void declare(Table& table) {
      constexpr double steepest = 89.0;  // deg
      const char* const rate_independent = "no rate dependence";
      HenckyModuli::Parameters::declare(table);
      table.add("cone_matching", &Parameters::cone_matching, {"plane_strain", "triaxial_compression", "simple_shear"})
          .text("Test on which the cone agrees with the Mohr-Coulomb angles; simple_shear: tan(friction angle) = sqrt(J2)/p, as for mu(I)");
      table.add("friction_angle_deg", &Parameters::friction_angle).degrees().positive(steepest).required().text("Friction angle phi");
      table.add("cohesion_pa", &Parameters::cohesion).unit("Pa").range(0.0, 1e9).text("Cohesion c");
      table.add("dilatancy_angle_deg", &Parameters::dilatancy_angle)
          .degrees()
          .range(0.0, steepest)
          .text("Dilatancy angle psi, at most the friction angle; 0 shears at constant volume");
      table.add("limit_friction_angle_deg", &Parameters::limit_friction_angle)
          .degrees()
          .positive(steepest)
          .left_out(rate_independent)
          .text("mu(I): friction angle of infinitely fast shear, at least friction_angle_deg");
      table.add("reference_inertial_number", &Parameters::reference_inertial_number)
          .positive(1e3)
          .left_out(rate_independent)
          .text("mu(I): I_0, where half of the increase is reached");
      table.add("grain_diameter_m", &Parameters::grain_diameter)
          .unit("m")
          .positive(10.0)
          .left_out(rate_independent)
          .text("mu(I): diameter d of grains");
      table.add("grain_density_kg_m3", &Parameters::grain_density)
          .unit("kg/m^3")
          .range(1.0, 1e5)
          .left_out(rate_independent)
          .text("mu(I): density rho_s of grains");
    }
    /// psi <= phi <= phi_2; the parameters of mu(I) all or none, and with them psi = 0
    void check(ParameterReport& report) const;
  };

  /// Beside what every law has.
  static constexpr OptionalMembers has{
      .expect_single_states = true, .yield_function = true, .plastic_volume_strain = true, .internal_friction = true, .check = true};

  /// @throws ConfigError if a parameter is out of range, or `check` finds a problem
  explicit DruckerPrager(const Parameters& parameters);

  /// Backward Euler step. The result is NaN in a lane whose deformation is inverted or not finite.
  /// @param dt  s, above 0; matters with rate dependence only
  template <LaneNumber T>
  void update_stress(MaterialState<T>& state, const Matrix3<T>& dl, double dt) const;

  /// Declares that states are rounded to single precision between steps: a trace of that size beside a deviator counts as zero.
  void expect_single_states() { round_off_ = 1e-6; }

  /// J = exp(tr eps + X)
  template <LaneNumber T>
  [[nodiscard]] T volume_ratio(const MaterialState<T>& state) const {
    return exp(trace(state.stress) * (1.0 / (3.0 * moduli_.bulk())) + state.internal);
  }
  [[nodiscard]] double density() const { return moduli_.density(); }        ///< rho_0, kg/m^3
  [[nodiscard]] double initial_internal() const { return 0.0; }             ///< X = 0
  [[nodiscard]] double wave_speed() const { return moduli_.wave_speed(); }  ///< c_P, m/s
  [[nodiscard]] double bulk_speed() const { return moduli_.bulk_speed(); }  ///< sqrt(K/rho_0), m/s
  [[nodiscard]] double stored_energy(const MaterialState<double>& state) const {
    return moduli_.stored_energy(state.stress);
  }                                                                     ///< elastic, J/m^3 of reference volume
  [[nodiscard]] const HenckyModuli& moduli() const { return moduli_; }  ///< the elastic part

  [[nodiscard]] double dilatancy_slope() const { return dilatancy_slope_; }  ///< A_psi
  /// A(I), the friction slope at an inertial number; A without rate dependence.
  [[nodiscard]] double friction_slope_at(double inertial_number) const;
  [[nodiscard]] double plastic_volume_strain(const MaterialState<double>& state) const { return state.internal; }  ///< X
  /// f (q + |A p + C|), Pa^2; <= 0 inside the rate-independent cone.
  [[nodiscard]] double yield_function(const MaterialState<double>& state) const;

 private:
  HenckyModuli moduli_;
  double slope_, intercept_, dilatancy_slope_;
  double apex_strain_;    // tr eps at the apex, C / (A K)
  double return_factor_;  // 1 / (1 + K A A_psi / (3 G))
  // mu(I): A_2 - A, and h / (dt sqrt(p)) = I_0 3 G / (sqrt(3 rho_s) d_g); both 0 without mu(I)
  double slope_increase_ = 0.0, hindrance_ = 0.0, reference_inertial_number_ = 0.0;
  double round_off_ = 1e-12;  // of a trace, over the deviator
};

template <LaneNumber T>
void DruckerPrager::update_stress(MaterialState<T>& state, const Matrix3<T>& dl, double dt) const {
  const double bulk = moduli_.bulk(), shear = moduli_.shear();
  const HenckyStrain<T> before = moduli_.strain(state.stress);
  HenckyStrain<T> strain = hencky_trial(before, dl);

  // A sheared point with p = 0 has this p only to round-off of its stress.
  const T squeezed = min(before.volumetric, T{});
  const T gap = select(squeezed * squeezed <= (round_off_ * round_off_) * norm2(before.deviator), state.internal, T{});
  const T closed = max(min(gap, -strain.volumetric), T{});
  strain.volumetric += closed;
  state.internal = state.internal - closed;
  const T open = gap - closed;

  const T p = -bulk * strain.volumetric;
  const T q = sqrt((6.0 * shear * shear) * norm2(strain.deviator));
  const T excess = q - (slope_ * p + intercept_);
  const Mask<T> yields = excess > 0.0;
  if (any(yields)) {
    T d = return_factor_ * excess;
    if (hindrance_ > 0.0) {
      const T pressure = max(p, T{});
      const T h = (hindrance_ * dt) * sqrt(pressure), b = h + slope_increase_ * pressure - excess;
      const T root = sqrt(b * b + 4.0 * excess * h);
      d = select(b > 0.0, 2.0 * excess * h / (b + root), 0.5 * (root - b));
    }
    T returned = strain.volumetric - (dilatancy_slope_ / (3.0 * shear)) * d;
    const Mask<T> loose = (open > 0.0) & (returned < 0.0);  // dilates to a pressure although its gap is open
    d = select(loose, q - intercept_, d);
    returned = select(loose, T{}, returned);
    const Mask<T> apex = yields & (q <= d);
    const T volumetric = select(yields, select(apex, broadcast<T>(apex_strain_), returned), strain.volumetric);
    state.internal += strain.volumetric - volumetric;
    strain.volumetric = volumetric;
    strain.deviator = select(yields, select(apex, T{}, 1.0 - d / q), broadcast<T>(1.0)) * strain.deviator;
  }
  state.stress = moduli_.stress(strain);
}

static_assert(Material<DruckerPrager>);

}  // namespace mpm
