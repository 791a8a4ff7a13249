#pragma once
/// The paper's two regressions (Sect. 4.1, Tables A1 and A2): coefficients of Eqs. 7-10 from the steady heights of many runs, by nonlinear
/// least squares with the Levenberg-Marquardt method of MINPACK (Eigen's port; scipy's curve_fit, which the paper used, calls MINPACK,
/// too).
///
/// Run-up is fitted to log(h/H), pressure height to h/H. All heights are divided by H, so that runs with different H weigh the same.

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "mpm/impact/scores.hpp"
#include "mpm/impact/semi_empirical.hpp"

namespace mpm {

/// One run, as Eqs. 7-10 see it: all numbers dimensionless.
struct HeightSample {
  double effective_friction;  ///< M' >= 0
  double froude;              ///< Fr >= 0
  double relative_height;     ///< steady mean over flow height, h/H > 0
};

/// A fitted coefficient. The standard error is that of curve_fit: sqrt of the diagonal of (J^T J)^-1 S / (n - p), J the Jacobian of the
/// residuals at the minimum, S the sum of their squares, n runs, p coefficients. It takes the equation to be right and the residuals to be
/// independent, of one size.
struct Coefficient {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double value = none;
  double standard_error = none;
  double t_statistic = none;  ///< value / standard_error
  double p_value = none;      ///< two-sided, of the hypothesis that the coefficient is 0, Student's t with n - p degrees of freedom

  [[nodiscard]] double relative_error() const;  ///< standard_error / |value|
};

/// The equations that differ in h_in (Eq. 10) and in the space of the residuals.
enum class HeightEquation { runup, pressure_height };

/// Sum of squares that is left when Fr_sat is held at a value and the other coefficients are fitted.
struct ProfilePoint {
  double saturation_froude;
  double sum_of_squares;
};

struct HeightFit {
  HeightEquation equation = HeightEquation::runup;
  HeightCoefficients coefficients{};        ///< saturation_froude infinite: none (always so for the run-up)
  Coefficient k, kappa, saturation_froude;  ///< saturation_froude without a value for the run-up, and without error where there is none
  std::size_t runs = 0;
  std::size_t degrees_of_freedom = 0;  ///< runs - fitted coefficients
  double sum_of_squares = 0.0;         ///< of log(h/H) or h/H

  /// Pressure height only. Fr_sat at which profile <= S_min (1 + t^2 / (n - 3)), t the 97.5 % quantile of Student's t: an interval of 95 %
  /// that needs no derivative by Fr_sat. The upper end is infinite where runs without saturation are as credible.
  double saturation_from = Coefficient::none, saturation_to = Coefficient::none;
  std::vector<ProfilePoint> saturation_profile;

  std::vector<std::string> cautions;  ///< sentences on what the standard errors do not tell
};

/// Fits the equation for run-up (k_r, kappa_r) or pressure height (k_p, kappa_p, Fr_sat).
///
/// min(Fr, Fr_sat)^2 has a kink in Fr_sat at every Froude number of the table, and the sum of squares may have a minimum between each pair.
/// Between two neighbours it is smooth, and for a given kappa a convex quadratic in (k, Fr_sat^2): so each such interval is searched on its
/// own from several kappas, its ends are candidates with Fr_sat held there, and the best of all is the global minimum. Beyond the highest
/// Froude number Fr_sat changes nothing: there is then no saturation.
///
/// @throws ConfigError for fewer than one run more than coefficients, for samples outside their ranges, and for samples that do not
/// determine the coefficients (no M' > 0; one Froude number only at M' > 0 and none that tells k from kappa)
[[nodiscard]] HeightFit fit_heights(HeightEquation equation, std::span<const HeightSample> samples);

/// h/H by Eqs. 7-10.
[[nodiscard]] double relative_height(const HeightSample& sample, const HeightCoefficients& coefficients);

/// Scores of the equation with these coefficients against the samples.
[[nodiscard]] Scores score_heights(std::span<const HeightSample> samples, const HeightCoefficients& coefficients);

/// P(|T| >= |t|) of Student's t distribution: the regularised incomplete beta function I_x(nu/2, 1/2) at x = nu / (nu + t^2).
/// @param degrees_of_freedom nu > 0.
[[nodiscard]] double two_sided_p_value(double t, double degrees_of_freedom);
/// t with two_sided_p_value(t, nu) = p: 1.96 for p = 0.05 and many degrees of freedom. @param p in (0, 1).
[[nodiscard]] double two_sided_quantile(double p, double degrees_of_freedom);

/// A row of Table A1 or A2.
struct PublishedEstimate {
  double value, relative_error, t_statistic;
};
/// Tables A1 and A2: what the paper found on its own data. Scores that the tables do not give are NaN.
struct PublishedFit {
  HeightCoefficients coefficients;
  PublishedEstimate k, kappa, saturation_froude;
  Scores scores;
};
[[nodiscard]] PublishedFit published_fit(HeightEquation equation);

}  // namespace mpm
