#pragma once
/// The paper's semi-empirical equations for run-up and pressure height, the guideline that they extend, the formulas of its set-up, and
/// analytic limits. Plain functions of numbers in SI units. Every function throws ConfigError outside its stated range.

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace mpm {

inline constexpr double standard_gravity = 9.81;  ///< g of the paper, m/s^2

// ---- Rheology -------------------------------------------------------------------------------------------------------------------------

/// Effective internal friction M' = (1 + beta) / ((1 - beta) sqrt(1 + 2 beta)) M, Eq. 2: the critical-state ratio q/p of the yield function
/// Eq. 3.
/// @param critical_state_slope M >= 0. @param cohesion_beta 0 <= beta < 1.
[[nodiscard]] double effective_friction(double critical_state_slope, double cohesion_beta);

/// Coulomb friction angle phi' = asin(3 M' / (M' + 6)), rad (text below Eq. 2). @param effective_friction 0 <= M' <= 3.
[[nodiscard]] double friction_angle(double effective_friction);

/// Bulk modulus K = E / (3 (1 - 2 nu)), Pa (Table 1). @param young_modulus E > 0, Pa. @param poisson_ratio -1 < nu < 1/2.
[[nodiscard]] double bulk_modulus(double young_modulus, double poisson_ratio);

/// Plastic compressibility chi(p_c) = J_P(p_c0) / J_P(p_c), J_P(p) = exp(-asinh(p/K) / xi), Eqs. A1-A2: factor by which plastic compaction
/// raises the density when p_c0 grows to p_c; 1 means no compaction. The paper quotes it in per cent at p_c = 25 kPa.
/// @param xi hardening parameter > 0. @param pressure p_c, Pa. @param initial_pressure p_c0, Pa. @param bulk_modulus K > 0, Pa.
[[nodiscard]] double plastic_compressibility(double xi, double pressure, double initial_pressure, double bulk_modulus);

// ---- Set-up ---------------------------------------------------------------------------------------------------------------------------

/// Fr = v / sqrt(g H). @param velocity m/s, >= 0. @param flow_height H > 0, m.
[[nodiscard]] double froude_number(double velocity, double flow_height, double gravity = standard_gravity);

/// v = Fr sqrt(g H), m/s. @param froude >= 0.
[[nodiscard]] double flow_velocity(double froude, double flow_height, double gravity = standard_gravity);

/// Width of the conveyor, W = (6 + 3 log10(xi / 0.05)) w, m (caption of Fig. 2; the base of the logarithm is a choice: ten gives 6 w, 9 w
/// and 12 w at xi = 0.05, 0.5 and 5). @param xi > 0, large enough for W > w. @param obstacle_width w > 0, m.
[[nodiscard]] double conveyor_width(double xi, double obstacle_width);

/// Length of the published avalanche, L = v t + 3 m: every row of Table 2 obeys it within its rounding.
[[nodiscard]] double conveyor_length(double velocity, double duration);

// ---- Eqs. 7-10 ------------------------------------------------------------------------------------------------------------------------

/// Regression coefficients of h/H = 1 + k M' + min(Fr, Fr_sat)^2 / 2 exp(-kappa M'), Eqs. 7-10.
struct HeightCoefficients {
  double k;                                                            ///< pile-up, Eq. 8
  double kappa;                                                        ///< dissipation, Eq. 10
  double saturation_froude = std::numeric_limits<double>::infinity();  ///< Fr_sat, Eq. 9; infinite: no saturation
};
inline constexpr HeightCoefficients runup_coefficients{0.9468, 1.5745};                    ///< Table A1, four digits
inline constexpr HeightCoefficients pressure_height_coefficients{0.5277, 1.3072, 1.5380};  ///< Table A2, four digits

/// zeta = k M', Eq. 8: quasi-static pile-up over H.
[[nodiscard]] double magnification_factor(double effective_friction, const HeightCoefficients& coefficients);
/// lambda = exp(kappa M'), Eq. 10: the velocity head is divided by it.
[[nodiscard]] double dissipation_factor(double effective_friction, const HeightCoefficients& coefficients);
/// Height by Eqs. 7-10, m, for an obstacle as wide as the flow is high (w/H = 1, the set-up of the regression).
/// @param effective_friction M' >= 0. @param velocity v >= 0, m/s. @param flow_height H > 0, m.
[[nodiscard]] double predicted_height(double effective_friction, double velocity, double flow_height,
                                      const HeightCoefficients& coefficients, double gravity = standard_gravity);
/// Which of these values are outside those that the equations were fitted to, for a message: "Fr = 20 (0.1 to 7)" (Sect. 2.2 and 4.3 of the
/// paper, Tables 1 and 2). @param relative_width w/H. @param effective_friction, hardening_xi  empty: the law has none
[[nodiscard]] std::vector<std::string> outside_of_equations(double froude, double relative_width, std::optional<double> effective_friction,
                                                            std::optional<double> hardening_xi);
/// Steady run-up by Eqs. 7-10 with Table A1, m.
[[nodiscard]] double predicted_runup(double effective_friction, double velocity, double flow_height, double gravity = standard_gravity);
/// Steady pressure height by Eqs. 7-10 with Table A2, m.
[[nodiscard]] double predicted_pressure_height(double effective_friction, double velocity, double flow_height,
                                               double gravity = standard_gravity);

// ---- Swiss guideline, Eqs. 5-6 --------------------------------------------------------------------------------------------------------

inline constexpr double guideline_lambda_loose = 1.5;          ///< dry, loose avalanches
inline constexpr double guideline_lambda_dense_low = 2.0;      ///< dense avalanches: 2 to 3
inline constexpr double guideline_lambda_dense = 3.0;          ///< dense avalanches, upper value
inline constexpr double recommended_width_factor_floor = 0.7;  ///< Sect. 5, for w/H < 1

/// f(w/H) = 1 - exp(-1.14 w/H), Eq. 6. @param relative_width w/H > 0.
[[nodiscard]] double width_factor(double relative_width);
/// max(f(w/H), 0.7), the floor that Sect. 5 recommends for w/H < 1. Eq. 6 gives 0.680 at w/H = 1 and passes 0.7 at 1.056; the floor applies
/// up to there, so that the factor never decreases with the width.
[[nodiscard]] double limited_width_factor(double relative_width);
/// h_r = v^2 / (2 g lambda) f, Eq. 5, m above the avalanche's surface: add H for the height above ground (text below Eq. 7).
/// @param lambda energy dissipation factor >= 1. @param width_factor f in (0, 1].
[[nodiscard]] double guideline_runup(double velocity, double lambda, double width_factor, double gravity = standard_gravity);

// ---- Analytic limits ------------------------------------------------------------------------------------------------------------------

/// v^2 / (2 g), Eq. 1, m: velocity head, and ballistic rise.
[[nodiscard]] double velocity_head(double velocity, double gravity = standard_gravity);
/// H + v^2 / (2 g), m: highest steady run-up of an inviscid flow (Bernoulli along the surface streamline).
[[nodiscard]] double bernoulli_height(double velocity, double flow_height, double gravity = standard_gravity);
/// Cauchy stagnation pressure of an elastic Hencky fluid, tau = -p_K I with p_K = -K ln J, Pa. With x = -ln J the compressible Bernoulli
/// equation reads K (x + x^2/2) / rho_0 = v^2/2, so that x = -1 + sqrt(1 + rho_0 v^2 / K) and p = K x exp(x). Above rho_0 v^2 / 2, and
/// tending to it for K -> infinity.
[[nodiscard]] double hencky_stagnation_pressure(double velocity, double density, double bulk_modulus);

}  // namespace mpm
