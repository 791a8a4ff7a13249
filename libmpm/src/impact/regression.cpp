#include "mpm/impact/regression.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unsupported/Eigen/LevenbergMarquardt>
#include <unsupported/Eigen/SpecialFunctions>

#include "mpm/error.hpp"

namespace mpm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Which runs follow Fr_sat. Within an interval of the search the answer does not change with Fr_sat, and the model is smooth.
struct Saturation {
  std::optional<double> split;  ///< runs with Fr > split have the head Fr_sat^2 / 2, and Fr_sat is fitted
  double held = infinity;       ///< Fr_sat where it is not fitted
};

/// Residuals prediction - observation and their Jacobian, parameters (k, kappa[, Fr_sat]). A prediction that has no logarithm is NaN, which
/// the method refuses as a step.
struct Residuals : Eigen::DenseFunctor<double> {
  Residuals(HeightEquation equation_, std::span<const HeightSample> samples_, const Saturation& saturation_)
      : DenseFunctor(saturation_.split ? 3 : 2, static_cast<int>(samples_.size())),
        equation(equation_),
        samples(samples_),
        saturation(saturation_) {}

  [[nodiscard]] bool saturated(const HeightSample& s) const { return saturation.split && s.froude > *saturation.split; }

  /// The sample with the Froude number that makes its head.
  [[nodiscard]] HeightSample effective(const HeightSample& s, const VectorXd& x) const {
    return {s.effective_friction, saturated(s) ? std::abs(x[2]) : std::min(s.froude, saturation.held), s.relative_height};
  }

  int operator()(const VectorXd& x, VectorXd& residual) const {
    for (Index i = 0; i < residual.size(); ++i) {
      const HeightSample& s = samples[static_cast<std::size_t>(i)];
      const double f = relative_height(effective(s, x), {x[0], x[1]});
      residual[i] = equation == HeightEquation::runup ? std::log(f / s.relative_height) : f - s.relative_height;
    }
    return 0;
  }

  int df(const VectorXd& x, MatrixXd& jacobian) const {
    for (Index i = 0; i < jacobian.rows(); ++i) {
      const HeightSample& s = samples[static_cast<std::size_t>(i)];
      const HeightSample e = effective(s, x);
      const double damping = std::exp(-x[1] * s.effective_friction);
      const double scale = equation == HeightEquation::runup ? 1.0 / relative_height(e, {x[0], x[1]}) : 1.0;
      jacobian(i, 0) = scale * s.effective_friction;
      jacobian(i, 1) = -scale * s.effective_friction * 0.5 * e.froude * e.froude * damping;
      if (saturation.split) jacobian(i, 2) = saturated(s) ? scale * x[2] * damping : 0.0;
    }
    return 0;
  }

  HeightEquation equation;
  std::span<const HeightSample> samples;
  Saturation saturation;
};

struct Minimum {
  VectorXd x;
  double sum_of_squares = infinity;
};

Minimum minimise(Residuals& residuals, VectorXd x) {
  Eigen::LevenbergMarquardt<Residuals> method(residuals);
  // Down to round-off: the default, the square root of it, would leave five digits in the standard errors.
  method.setXtol(1e-13);
  method.setFtol(1e-15);
  method.minimize(x);
  VectorXd residual(residuals.values());
  residuals(x, residual);
  const double sum = residual.squaredNorm();
  return {x, std::isfinite(sum) ? sum : infinity};
}

/// kappa spans what the exponential can mean for M' of order 1: from no dissipation to none of the head left.
constexpr std::array start_kappas{0.0, 1.0, 4.0};

Minimum best_of_starts(Residuals residuals, std::optional<double> start_froude) {
  Minimum best;
  for (const double kappa : start_kappas) {
    VectorXd x(residuals.inputs());
    x[0] = 1.0;
    x[1] = kappa;
    if (start_froude) x[2] = *start_froude;
    Minimum found = minimise(residuals, std::move(x));
    if (found.sum_of_squares < best.sum_of_squares) best = std::move(found);
  }
  return best;
}

std::vector<double> froude_numbers(std::span<const HeightSample> samples) {
  std::vector<double> froude;
  for (const HeightSample& s : samples) froude.push_back(s.froude);
  std::ranges::sort(froude);
  froude.erase(std::unique(froude.begin(), froude.end()), froude.end());
  return froude;
}

struct SaturationMinimum {
  Minimum minimum;
  Saturation saturation;
  double froude = infinity;  ///< Fr_sat
};

/// Global minimum over Fr_sat, see fit_heights().
SaturationMinimum search_saturation(std::span<const HeightSample> samples, const std::vector<double>& knots) {
  constexpr auto equation = HeightEquation::pressure_height;
  SaturationMinimum best;
  const auto offer = [&](Minimum minimum, const Saturation& saturation, double froude) {
    if (minimum.sum_of_squares < best.minimum.sum_of_squares) best = {std::move(minimum), saturation, froude};
  };
  // From the right, where there is no saturation: of equal minima the one with the fewest coefficients is kept.
  offer(best_of_starts(Residuals(equation, samples, {}), {}), {}, infinity);
  for (std::size_t j = knots.size(); j-- > 0;) {
    const double from = j > 0 ? knots[j - 1] : 0.0, to = knots[j];
    if (from == to) continue;  // the lowest Froude number is 0
    const Saturation at_end{{}, from};
    offer(best_of_starts(Residuals(equation, samples, at_end), {}), at_end, from);
    const Saturation inside{from, infinity};
    Minimum found = best_of_starts(Residuals(equation, samples, inside), 0.5 * (from + to));
    const double froude = std::isfinite(found.sum_of_squares) ? std::abs(found.x[2]) : infinity;
    if (froude > from && froude < to) offer(std::move(found), inside, froude);
  }
  return best;
}

double sum_with_saturation(std::span<const HeightSample> samples, double froude, const VectorXd& start) {
  Residuals residuals(HeightEquation::pressure_height, samples, {{}, froude});
  return minimise(residuals, start.head(2)).sum_of_squares;
}

/// Profile of the sum of squares over Fr_sat, and the interval that it supports.
void profile_saturation(HeightFit& fit, std::span<const HeightSample> samples, const std::vector<double>& knots, const VectorXd& best) {
  constexpr int steps = 20;  // between two Froude numbers of the table
  std::vector<double> froude{0.0};
  for (std::size_t j = 0; j < knots.size(); ++j) {
    const double from = j > 0 ? knots[j - 1] : 0.0;
    for (int i = 1; i <= steps; ++i) froude.push_back(from + (knots[j] - from) * i / steps);
  }
  if (std::isfinite(fit.coefficients.saturation_froude)) froude.push_back(fit.coefficients.saturation_froude);
  std::ranges::sort(froude);
  froude.erase(std::unique(froude.begin(), froude.end()), froude.end());
  for (const double f : froude) fit.saturation_profile.push_back({f, sum_with_saturation(samples, f, best)});

  const auto n = static_cast<double>(samples.size());
  const double t = two_sided_quantile(0.05, n - 3.0);
  // Round-off of exact data: their sum of squares is a few squares of epsilon.
  const double limit = fit.sum_of_squares * (1.0 + t * t / (n - 3.0)) + n * 1e-28;
  const auto credible = [&](const ProfilePoint& p) { return p.sum_of_squares <= limit; };
  const auto& profile = fit.saturation_profile;
  const auto first = std::ranges::find_if(profile, credible);
  const auto last = std::find_if(profile.rbegin(), profile.rend(), credible).base();  // one past it
  const auto bisect = [&](double inside, double outside) {
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (inside + outside);
      (sum_with_saturation(samples, middle, best) <= limit ? inside : outside) = middle;
    }
    return inside;
  };
  fit.saturation_from = first == profile.begin() ? 0.0 : bisect(first->saturation_froude, (first - 1)->saturation_froude);
  fit.saturation_to = last == profile.end() ? infinity : bisect((last - 1)->saturation_froude, last->saturation_froude);
}

Coefficient coefficient(double value, double variance, double degrees_of_freedom) {
  const double error = std::sqrt(variance);
  return {value, error, value / error, two_sided_p_value(value / error, degrees_of_freedom)};
}

void require_samples(HeightEquation equation, std::span<const HeightSample> samples) {
  const std::size_t coefficients = equation == HeightEquation::runup ? 2 : 3;
  if (samples.size() <= coefficients) {
    throw ConfigError(fmt::format("regression of {} coefficients: {} runs are left; it needs {} or more", coefficients, samples.size(),
                                  coefficients + 1));
  }
  for (const HeightSample& s : samples) {
    if (!(s.effective_friction >= 0.0 && s.froude >= 0.0 && s.relative_height > 0.0) || !std::isfinite(s.effective_friction) ||
        !std::isfinite(s.froude) || !std::isfinite(s.relative_height)) {
      throw ConfigError(fmt::format("regression: a run with M' = {}, Fr = {}, h/H = {}: M' and Fr must be at least 0, h/H greater than 0",
                                    s.effective_friction, s.froude, s.relative_height));
    }
  }
}

/// (J^T J)^-1 by an orthogonal decomposition of J with columns of length 1, so that the units of the coefficients do not matter.
MatrixXd inverse_normal_matrix(MatrixXd jacobian) {
  constexpr double smallest = 1e-9;  // of the diagonal of R: the coefficients' errors would exceed their residuals' a billion times
  VectorXd length = jacobian.colwise().norm();
  for (Index c = 0; c < jacobian.cols(); ++c) jacobian.col(c) /= length[c] > 0.0 ? length[c] : 1.0;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(jacobian);
  qr.setThreshold(smallest);
  if (qr.rank() < jacobian.cols()) {
    throw ConfigError(
        "regression: the runs do not determine the coefficients; k needs runs with M' > 0, kappa runs with M' > 0 at two or more Froude "
        "numbers, one of them well above 0");
  }
  MatrixXd inverse = length.cwiseInverse().asDiagonal() * jacobian.transpose().lazyProduct(jacobian).eval().inverse() *
                     MatrixXd(length.cwiseInverse().asDiagonal());
  return inverse;
}

void caution_about_saturation(HeightFit& fit, const std::vector<double>& knots) {
  const double froude = fit.coefficients.saturation_froude, error = fit.saturation_froude.standard_error;
  if (!std::isfinite(froude)) {
    fit.cautions.emplace_back("no saturation: the best fit lets the pressure height grow up to the highest Froude number of the table");
    return;
  }
  const auto above = std::ranges::upper_bound(knots, froude);
  const bool on_knot = above != knots.begin() && *(above - 1) == froude;
  if (on_knot) {
    fit.cautions.push_back(
        fmt::format("Fr_sat lies on {}, a Froude number of the table, where the equation has a kink: the standard errors are those of its "
                    "upper side only; take the interval instead",
                    froude));
    return;
  }
  const double below = above == knots.begin() ? 0.0 : *(above - 1);
  fit.cautions.push_back(
      fmt::format("Fr_sat lies between {} and {} of the table, with no run in between: the runs show the height of the plateau, and Fr_sat "
                  "is where the velocity head would reach it, not an onset that was seen",
                  below, *above));
  if (froude - 2.0 * error < below || froude + 2.0 * error > *above) {
    fit.cautions.push_back(
        fmt::format("Fr_sat +- 2 standard errors, {:.3f} to {:.3f}, reaches over a Froude number of the table, where the equation has a "
                    "kink: its standard error, t and p are not trustworthy; take the interval instead",
                    froude - 2.0 * error, froude + 2.0 * error));
  }
}

}  // namespace

double Coefficient::relative_error() const { return standard_error / std::abs(value); }

double relative_height(const HeightSample& sample, const HeightCoefficients& coefficients) {
  return predicted_height(sample.effective_friction, sample.froude, 1.0, coefficients, 1.0);
}

Scores score_heights(std::span<const HeightSample> samples, const HeightCoefficients& coefficients) {
  std::vector<double> simulated, predicted;
  for (const HeightSample& s : samples) {
    simulated.push_back(s.relative_height);
    predicted.push_back(relative_height(s, coefficients));
  }
  return compute_scores(simulated, predicted);
}

HeightFit fit_heights(HeightEquation equation, std::span<const HeightSample> samples) {
  require_samples(equation, samples);
  const std::vector<double> knots = froude_numbers(samples);
  SaturationMinimum best;
  if (equation == HeightEquation::runup) {
    best.minimum = best_of_starts(Residuals(equation, samples, {}), {});
  } else {
    best = search_saturation(samples, knots);
  }
  if (!std::isfinite(best.minimum.sum_of_squares)) throw Error(ExitCode::internal, "regression: no start led to a finite sum of squares");

  HeightFit fit;
  fit.equation = equation;
  fit.coefficients = {best.minimum.x[0], best.minimum.x[1], best.froude};
  fit.runs = samples.size();
  fit.sum_of_squares = best.minimum.sum_of_squares;

  const bool with_saturation = std::isfinite(best.froude);
  // On a kink the derivative of the upper side, as forward differences would give it.
  Residuals residuals(equation, samples, with_saturation && !best.saturation.split ? Saturation{best.froude, infinity} : best.saturation);
  VectorXd x(residuals.inputs());
  x.head(2) = best.minimum.x.head(2);
  if (with_saturation) x[2] = best.froude;
  MatrixXd jacobian(residuals.values(), residuals.inputs());
  residuals.df(x, jacobian);
  fit.degrees_of_freedom = fit.runs - static_cast<std::size_t>(residuals.inputs());
  const auto degrees = static_cast<double>(fit.degrees_of_freedom);
  const MatrixXd covariance = inverse_normal_matrix(std::move(jacobian)) * (fit.sum_of_squares / degrees);
  fit.k = coefficient(x[0], covariance(0, 0), degrees);
  fit.kappa = coefficient(x[1], covariance(1, 1), degrees);
  if (equation == HeightEquation::pressure_height) {
    fit.saturation_froude = with_saturation ? coefficient(best.froude, covariance(2, 2), degrees) : Coefficient{.value = infinity};
    profile_saturation(fit, samples, knots, best.minimum.x);
    caution_about_saturation(fit, knots);
  }
  return fit;
}

double two_sided_p_value(double t, double degrees_of_freedom) {
  if (!std::isfinite(t)) return std::isnan(t) ? t : 0.0;
  return Eigen::numext::betainc(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
}

double two_sided_quantile(double p, double degrees_of_freedom) {
  double low = 0.0, high = 1.0;
  while (two_sided_p_value(high, degrees_of_freedom) > p) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (two_sided_p_value(middle, degrees_of_freedom) > p ? low : high) = middle;
  }
  return high;
}

PublishedFit published_fit(HeightEquation equation) {
  constexpr double none = Coefficient::none;
  if (equation == HeightEquation::runup) {
    return {
        .coefficients = runup_coefficients,
        .k = {runup_coefficients.k, 0.0457, 21.888},
        .kappa = {runup_coefficients.kappa, 0.0188, 53.300},
        .saturation_froude = {none, none, none},
        .scores = {.r2 = none, .r2_log = 0.939, .nrmse = none, .rmsle = 0.130, .bias = 0.981, .fraction_10 = 0.663, .fraction_25 = 0.929}};
  }
  return {.coefficients = pressure_height_coefficients,
          .k = {pressure_height_coefficients.k, 0.0186, 53.893},
          .kappa = {pressure_height_coefficients.kappa, 0.0924, 10.819},
          .saturation_froude = {pressure_height_coefficients.saturation_froude, 0.0370, 27.052},
          .scores = {.r2 = 0.752, .r2_log = none, .nrmse = 0.066, .rmsle = none, .bias = 1.011, .fraction_10 = 0.852, .fraction_25 = 1.0}};
}

}  // namespace mpm
