#include "mpm/impact/regression.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "mpm/error.hpp"

namespace mpm {
namespace {

constexpr std::array paper_froude{0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0};
constexpr std::array frictions{0.0, 0.4, 0.8, 1.2};
constexpr std::array cohesions{0.0, 0.15, 0.3, 0.45};

/// The paper's grid of (Fr, M, beta), heights by Eqs. 7-10.
std::vector<HeightSample> exact_samples(const HeightCoefficients& c) {
  std::vector<HeightSample> samples;
  for (const double froude : paper_froude) {
    for (const double m : frictions) {
      for (const double beta : cohesions) {
        HeightSample s{effective_friction(m, beta), froude, 1.0};
        s.relative_height = relative_height(s, c);
        samples.push_back(s);
      }
    }
  }
  return samples;
}

/// The same with a reproducible scatter of 10 % that a few lines of any language repeat.
std::vector<HeightSample> scattered_samples(const HeightCoefficients& c) {
  auto samples = exact_samples(c);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].relative_height *= std::exp(0.1 * std::sin(7.0 * static_cast<double>(i + 1)));
  return samples;
}

TEST(Regression, RecoversRunupCoefficientsFromExactData) {
  for (const HeightCoefficients c : {runup_coefficients, HeightCoefficients{0.2, 0.3}, HeightCoefficients{2.0, 3.5}}) {
    const HeightFit fit = fit_heights(HeightEquation::runup, exact_samples(c));
    EXPECT_NEAR(fit.coefficients.k, c.k, 1e-10);  // the method stops at round-off; two digits for the conditioning, two more for safety
    EXPECT_NEAR(fit.coefficients.kappa, c.kappa, 1e-10);
    EXPECT_EQ(fit.coefficients.saturation_froude, std::numeric_limits<double>::infinity());
    EXPECT_LT(fit.k.standard_error, 1e-10);
    EXPECT_LT(fit.k.p_value, 1e-100);
  }
}

TEST(Regression, RecoversPressureHeightCoefficientsWhereverTheFlowSaturates) {
  // In every interval between the table's Froude numbers, below the first, and on one of them.
  for (const double saturation : {0.2, 0.7, 1.538, 2.0, 2.5, 4.0, 6.9}) {
    const HeightCoefficients c{0.5277, 1.3072, saturation};
    const HeightFit fit = fit_heights(HeightEquation::pressure_height, exact_samples(c));
    EXPECT_NEAR(fit.coefficients.k, c.k, 1e-9) << saturation;
    EXPECT_NEAR(fit.coefficients.kappa, c.kappa, 1e-8) << saturation;  // at Fr_sat = 0.2 the head it acts on is 2 % of the height
    EXPECT_NEAR(fit.coefficients.saturation_froude, saturation, 1e-8);
    EXPECT_EQ(fit.degrees_of_freedom, fit.runs - 3);
  }
}

TEST(Regression, SaysThatThereIsNoSaturationWhereThePressureHeightKeepsGrowing) {
  const HeightFit fit = fit_heights(HeightEquation::pressure_height, exact_samples({0.5, 1.3}));
  EXPECT_EQ(fit.coefficients.saturation_froude, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(fit.coefficients.kappa, 1.3, 1e-9);
  EXPECT_EQ(fit.degrees_of_freedom, fit.runs - 2);
  EXPECT_TRUE(std::isnan(fit.saturation_froude.standard_error));
  ASSERT_EQ(fit.cautions.size(), 1u);
  EXPECT_NE(fit.cautions[0].find("no saturation"), std::string::npos);
}

/// Value and standard error, and p where scipy gives it.
void expect_estimate(const Coefficient& e, double value, double standard_error, double p_value) {
  // Both call a port of MINPACK; the finite differences of curve_fit leave seven digits of the minimum and four of the errors (seen: the
  // errors agree with the exact Jacobian's below to 1e-7). p is that of a t that is off by as much.
  EXPECT_NEAR(e.value / value, 1.0, 1e-7);
  EXPECT_NEAR(e.standard_error / standard_error, 1.0, 1e-4);
  EXPECT_NEAR(e.t_statistic / (value / standard_error), 1.0, 1e-4);
  EXPECT_NEAR(std::log(e.p_value) / std::log(p_value), 1.0, 1e-4);
}

// scipy 1.10.1: curve_fit on the same samples from p0 = the true coefficients, log(h) for the run-up, ftol = xtol = gtol = 1e-15; standard
// errors from the diagonal of pcov, p from 2 scipy.stats.t.sf(t, n - p).
TEST(Regression, GivesWhatCurveFitGives) {
  const HeightFit runup = fit_heights(HeightEquation::runup, scattered_samples(runup_coefficients));
  expect_estimate(runup.k, 0.9428514610001156, 0.019388934013024984, 3.33171559e-76);
  expect_estimate(runup.kappa, 1.5803444759270757, 0.027003113215713408, 1.00314137e-84);
  const HeightFit pressure = fit_heights(HeightEquation::pressure_height, scattered_samples(pressure_height_coefficients));
  expect_estimate(pressure.k, 0.5232771064182661, 0.01576773965997657, 8.38438728e-59);
  expect_estimate(pressure.kappa, 1.285532082127435, 0.09538997077554409, 5.89671364e-25);
  expect_estimate(pressure.saturation_froude, 1.5374687407002194, 0.020882833245324348, 8.91536774e-95);
}

/// Least squares by (J^T J)^-1 with J by central differences of the equation: nothing in common with the analytic Jacobian of the fit.
TEST(Regression, StandardErrorsAreThoseOfTheGaussNewtonCovariance) {
  for (const auto equation : {HeightEquation::runup, HeightEquation::pressure_height}) {
    const auto samples = scattered_samples(published_fit(equation).coefficients);
    const HeightFit fit = fit_heights(equation, samples);
    const bool logarithmic = equation == HeightEquation::runup;
    const std::size_t n = logarithmic ? 2 : 3;
    const auto residual = [&](const HeightSample& s, const std::array<double, 3>& x) {
      const double f = relative_height(s, {x[0], x[1], x[2]});
      return logarithmic ? std::log(f / s.relative_height) : f - s.relative_height;
    };
    const std::array<double, 3> best{fit.coefficients.k, fit.coefficients.kappa, fit.coefficients.saturation_froude};
    std::array<std::array<double, 3>, 3> normal{};
    double sum = 0.0;
    for (const HeightSample& s : samples) {
      std::array<double, 3> gradient{};
      for (std::size_t a = 0; a < n; ++a) {
        constexpr double h = 1e-5;  // error of the central difference h^2 = 1e-10 of a coefficient of order 1
        auto up = best, down = best;
        up[a] += h;
        down[a] -= h;
        gradient[a] = (residual(s, up) - residual(s, down)) / (2.0 * h);
      }
      for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b < n; ++b) normal[a][b] += gradient[a] * gradient[b];
      }
      sum += residual(s, best) * residual(s, best);
    }
    // Diagonal of the inverse by cofactors.
    const auto minor = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
      return normal[a][c] * normal[b][d] - normal[a][d] * normal[b][c];
    };
    const double variance = sum / static_cast<double>(samples.size() - n);
    EXPECT_NEAR(fit.sum_of_squares / sum, 1.0, 1e-12);
    constexpr double tolerance = 1e-7;  // of the differences, times the conditioning
    if (logarithmic) {
      const double determinant = minor(0, 1, 0, 1);
      EXPECT_NEAR(fit.k.standard_error / std::sqrt(variance * normal[1][1] / determinant), 1.0, tolerance);
      EXPECT_NEAR(fit.kappa.standard_error / std::sqrt(variance * normal[0][0] / determinant), 1.0, tolerance);
    } else {
      const double determinant = normal[0][0] * minor(1, 2, 1, 2) - normal[0][1] * minor(1, 2, 0, 2) + normal[0][2] * minor(1, 2, 0, 1);
      EXPECT_NEAR(fit.k.standard_error / std::sqrt(variance * minor(1, 2, 1, 2) / determinant), 1.0, tolerance);
      EXPECT_NEAR(fit.kappa.standard_error / std::sqrt(variance * minor(0, 2, 0, 2) / determinant), 1.0, tolerance);
      EXPECT_NEAR(fit.saturation_froude.standard_error / std::sqrt(variance * minor(0, 1, 0, 1) / determinant), 1.0, tolerance);
    }
  }
}

/// With kappa = 0 known to the data (M' = 0 only where Fr > 0) the equation is linear in k: h/H - 1 = k M', whose closed form is known.
TEST(Regression, IsTheClosedFormWhereTheEquationIsLinear) {
  // M' > 0 at Fr = 0 gives k alone; two exact runs at M' = 1, Fr = 100 pin kappa, and weigh on k by their own residuals, which are 0.
  std::vector<HeightSample> samples;
  double xx = 0.0, xy = 0.0;
  for (int i = 1; i <= 8; ++i) {
    const double m = 0.25 * i, h = 1.0 + 0.9 * m + 0.05 * std::sin(3.0 * i);
    samples.push_back({m, 0.0, h});
    xx += m * m;
    xy += m * (h - 1.0);
  }
  const double k = xy / xx;
  double residual = 0.0;
  for (const HeightSample& s : samples) {
    const double r = s.relative_height - 1.0 - k * s.effective_friction;
    residual += r * r;
  }
  samples.push_back({0.5, 2.0, 0.0});  // kappa takes up what this run leaves: its residual is 0 for any k
  samples.back().relative_height = relative_height(samples.back(), {0.9, 1.2});
  const HeightFit fit = fit_heights(HeightEquation::pressure_height, samples);
  EXPECT_EQ(fit.coefficients.saturation_froude, std::numeric_limits<double>::infinity());  // only one Froude number above 0
  EXPECT_NEAR(fit.k.value, k, 1e-9);
  EXPECT_NEAR(fit.k.standard_error, std::sqrt(residual / 7.0 / xx), 1e-9);  // 9 runs, 2 coefficients
}

class MonteCarlo : public ::testing::Test {
 protected:
  static constexpr int trials = 200;
  static constexpr double scatter = 0.05;

  /// Mean and standard deviation of the estimates, and the mean of their standard errors.
  struct Distribution {
    double mean = 0.0, deviation = 0.0, mean_error = 0.0;
  };
  static Distribution distribution(const std::vector<Coefficient>& estimates) {
    Distribution d;
    for (const Coefficient& e : estimates) {
      d.mean += e.value / trials;
      d.mean_error += e.standard_error / trials;
    }
    for (const Coefficient& e : estimates) d.deviation += (e.value - d.mean) * (e.value - d.mean) / (trials - 1);
    d.deviation = std::sqrt(d.deviation);
    return d;
  }
};

TEST_F(MonteCarlo, StandardErrorsAreTheScatterOfTheEstimates) {
  std::mt19937 generator(20240607);
  std::normal_distribution<double> normal(0.0, scatter);
  for (const auto equation : {HeightEquation::runup, HeightEquation::pressure_height}) {
    const HeightCoefficients truth = published_fit(equation).coefficients;
    const auto exact = exact_samples(truth);
    std::vector<Coefficient> k, kappa, froude;
    int covered = 0;
    for (int trial = 0; trial < trials; ++trial) {
      auto samples = exact;
      for (HeightSample& s : samples) {
        if (equation == HeightEquation::runup) s.relative_height *= std::exp(normal(generator));
        if (equation == HeightEquation::pressure_height) s.relative_height += normal(generator);
      }
      const HeightFit fit = fit_heights(equation, samples);
      k.push_back(fit.k);
      kappa.push_back(fit.kappa);
      froude.push_back(fit.saturation_froude);
      covered += fit.saturation_from <= truth.saturation_froude && truth.saturation_froude <= fit.saturation_to ? 1 : 0;
    }
    // The standard deviation of 200 normal numbers is known to 1/sqrt(400) = 5 %: four of them. Their mean to 1/14 of it: four again.
    const auto check = [](const Distribution& d, double value) {
      EXPECT_NEAR(d.mean_error / d.deviation, 1.0, 0.2);
      EXPECT_NEAR(d.mean, value, 0.28 * d.deviation);
    };
    check(distribution(k), truth.k);
    check(distribution(kappa), truth.kappa);
    if (equation == HeightEquation::pressure_height) {
      check(distribution(froude), truth.saturation_froude);
      EXPECT_NEAR(covered / double{trials}, 0.95, 0.062);  // four standard deviations of a share of 200
    }
  }
}

/// The search must not stop in a minimum beside the lowest: compare with a blind scan of (kappa, Fr_sat) with k by linear least squares.
TEST(Regression, FindsTheLowestOfAllMinimaOverTheSaturation) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> height(1.0, 4.0);
  for (int trial = 0; trial < 20; ++trial) {  // heights without any sense: the sum of squares has many minima
    std::vector<HeightSample> samples;
    for (const double froude : {0.5, 1.0, 2.0, 3.0, 4.0}) {
      for (const double m : {0.0, 0.5, 1.5}) samples.push_back({m, froude, height(generator)});
    }
    const HeightFit fit = fit_heights(HeightEquation::pressure_height, samples);
    double lowest = 1e300;
    for (int i = 0; i <= 400; ++i) {
      for (int j = -40; j <= 400; ++j) {
        const double saturation = 0.01 * i, kappa = 0.02 * j;
        double mm = 0.0, my = 0.0, yy = 0.0;
        for (const HeightSample& s : samples) {
          const double y = s.relative_height - relative_height(s, {0.0, kappa, saturation});
          mm += s.effective_friction * s.effective_friction;
          my += s.effective_friction * y;
          yy += y * y;
        }
        lowest = std::min(lowest, yy - my * my / mm);
      }
    }
    EXPECT_LE(fit.sum_of_squares, lowest * (1.0 + 1e-9)) << trial;
    EXPECT_GE(fit.sum_of_squares, lowest * 0.98) << trial;  // the scan's steps of 0.01 and 0.02
  }
}

TEST(Regression, ProfileHasItsLowestPointAtTheFitAndTheIntervalAtItsLimit) {
  const auto samples = scattered_samples(pressure_height_coefficients);
  const HeightFit fit = fit_heights(HeightEquation::pressure_height, samples);
  ASSERT_GT(fit.saturation_profile.size(), 100u);
  double lowest = 1e300;
  for (const ProfilePoint& p : fit.saturation_profile) {
    lowest = std::min(lowest, p.sum_of_squares);
    if (p.saturation_froude < fit.saturation_from || p.saturation_froude > fit.saturation_to) {
      EXPECT_GT(p.sum_of_squares, fit.sum_of_squares * (1.0 + 3.9 / static_cast<double>(fit.degrees_of_freedom)));  // t^2 > 1.96^2
    }
  }
  EXPECT_NEAR(lowest / fit.sum_of_squares, 1.0, 1e-9);
  EXPECT_LT(fit.saturation_from, fit.coefficients.saturation_froude);
  EXPECT_GT(fit.saturation_to, fit.coefficients.saturation_froude);
}

TEST(Regression, SaysWhenTheErrorOfTheSaturationIsNotTrustworthy) {
  const auto mentions = [](const HeightFit& fit, const char* text) {
    for (const std::string& caution : fit.cautions) {
      if (caution.find(text) != std::string::npos) return true;
    }
    return false;
  };
  const auto samples = scattered_samples({0.5277, 1.3072, 1.98});  // 0.02 below a Froude number of the table
  EXPECT_TRUE(mentions(fit_heights(HeightEquation::pressure_height, samples), "not trustworthy"));
  const HeightFit sharp = fit_heights(HeightEquation::pressure_height, exact_samples(pressure_height_coefficients));
  EXPECT_FALSE(mentions(sharp, "not trustworthy"));
  EXPECT_TRUE(mentions(sharp, "no run in between"));
}

TEST(Regression, RefusesRunsThatDoNotDetermineTheCoefficients) {
  std::vector<HeightSample> samples;
  for (const double froude : paper_froude) samples.push_back({0.0, froude, 1.0 + 0.5 * froude * froude});
  EXPECT_THROW((void)fit_heights(HeightEquation::runup, samples), ConfigError);  // M' = 0 only
  samples = exact_samples(runup_coefficients);
  EXPECT_THROW((void)fit_heights(HeightEquation::runup, std::span(samples).first(2)), ConfigError);
  EXPECT_THROW((void)fit_heights(HeightEquation::pressure_height, std::span(samples).first(3)), ConfigError);
  for (const HeightSample bad : {HeightSample{0.5, 1.0, 0.0}, HeightSample{-0.1, 1.0, 2.0}, HeightSample{0.5, -1.0, 2.0},
                                 HeightSample{0.5, 1.0, std::nan("")}, HeightSample{std::nan(""), 1.0, 2.0}}) {
    auto with_bad = samples;
    with_bad.push_back(bad);
    EXPECT_THROW((void)fit_heights(HeightEquation::runup, with_bad), ConfigError);
  }
}

TEST(Regression, ScoresOfExactDataArePerfect) {
  const auto samples = exact_samples(pressure_height_coefficients);
  const Scores s = score_heights(samples, pressure_height_coefficients);
  EXPECT_EQ(s.rmsle, 0.0);
  EXPECT_EQ(s.r2, 1.0);
}

TEST(StudentT, MatchesClosedFormsAndTables) {
  // One degree of freedom is Cauchy: P = 1 - 2/pi atan t; two: P = 1 - t / sqrt(2 + t^2).
  for (const double t : {0.1, 1.0, 3.0, 20.0}) {
    EXPECT_NEAR(two_sided_p_value(t, 1.0), 1.0 - 2.0 / M_PI * std::atan(t), 1e-14);
    EXPECT_NEAR(two_sided_p_value(-t, 2.0), 1.0 - t / std::sqrt(2.0 + t * t), 1e-14);
  }
  // scipy.stats.t.sf
  EXPECT_NEAR(two_sided_p_value(2.5, 310.0) / 0.012935757919019476, 1.0, 1e-12);
  EXPECT_NEAR(two_sided_p_value(10.819, 313.0) / 2.1859196165827013e-23, 1.0, 1e-10);  // logarithm of -52: two digits fewer
  EXPECT_NEAR(two_sided_p_value(53.9, 313.0) / 1.9361071161238698e-160, 1.0, 1e-10);
  EXPECT_EQ(two_sided_p_value(std::numeric_limits<double>::infinity(), 5.0), 0.0);
  EXPECT_NEAR(two_sided_quantile(0.05, 4.0), 2.776, 5e-4);  // printed tables: three decimals
  EXPECT_NEAR(two_sided_quantile(0.05, 19.0), 2.093, 5e-4);
  EXPECT_NEAR(two_sided_quantile(0.05, 1e6), 1.960, 5e-4);
}

TEST(PublishedFit, IsConsistentInItself) {
  // Tables A1 and A2 print t = 1 / relative error, both rounded: 3 digits of the error.
  for (const auto equation : {HeightEquation::runup, HeightEquation::pressure_height}) {
    const PublishedFit p = published_fit(equation);
    for (const PublishedEstimate& e : {p.k, p.kappa, p.saturation_froude}) {
      if (std::isfinite(e.value)) {
        EXPECT_NEAR(e.t_statistic * e.relative_error, 1.0, 0.003);
      }
    }
  }
}

}  // namespace
}  // namespace mpm
