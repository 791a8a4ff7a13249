#include "libmpm/driver/convergence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm {
namespace {

std::vector<double> manufactured(const std::vector<double>& h, double limit, double a, double p) {
  std::vector<double> f;
  for (const double hi : h) f.push_back(limit + a * std::pow(hi, p));
  return f;
}

TEST(ObservedOrder, IsExactForAPowerLawOnAnyRatios) {
  for (const double p : {0.4, 1.0, 1.7, 2.0, 3.5})
    for (const auto& h :
         {std::vector{0.4, 0.2, 0.1}, std::vector{0.25, 0.175, 0.125}, std::vector{0.5, 0.25, 0.175}, std::vector{0.3, 0.23, 0.1}})
      for (const double a : {3.0, -3.0}) {
        const auto f = manufactured(h, 3.78, a, p);
        const ThreeGrids t = observed_order(h[2], f[2], h[1], f[1], h[0], f[0]);
        EXPECT_EQ(t.behaviour, Behaviour::monotone);
        // differences of numbers near 4 carry 1e-15 absolute; divided by differences of 1e-3 or more
        EXPECT_NEAR(t.order, p, 1e-9) << h[1] << ' ' << a;
        EXPECT_NEAR(t.extrapolated, 3.78, 1e-9);
      }
}

TEST(ObservedOrder, ForAConstantRatioIsTheLogarithmOfTheDifferences) {
  const ThreeGrids t = observed_order(1.0, 1.0, 2.0, 1.3, 4.0, 2.9);
  EXPECT_NEAR(t.order, std::log(1.6 / 0.3) / std::log(2.0), 1e-12);
}

TEST(ObservedOrder, OfPublishedUnequalGridsIsTheirs) {
  // Celik et al. (2008), Table 1: grids of 18000, 8000 and 4500 cells in 2D, reattachment length 6.063, 5.972, 5.863: p = 1.53, f_ext
  // = 6.1685
  const double n1 = 18000, n2 = 8000, n3 = 4500;
  const double h1 = 1 / std::sqrt(n1), h2 = 1 / std::sqrt(n2), h3 = 1 / std::sqrt(n3);
  const ThreeGrids t = observed_order(h1, 6.063, h2, 5.972, h3, 5.863);
  EXPECT_NEAR(t.order, 1.53, 0.01);  // printed with two decimals
  EXPECT_NEAR(t.extrapolated, 6.1685, 5e-4);
}

TEST(ObservedOrder, HasNoMeaningForOscillatingDivergentOrConstantValues) {
  const ThreeGrids oscillating = observed_order(0.1, 1.0, 0.2, 1.1, 0.4, 0.9);
  EXPECT_EQ(oscillating.behaviour, Behaviour::oscillating);
  EXPECT_TRUE(std::isnan(oscillating.order) && std::isnan(oscillating.extrapolated));
  EXPECT_EQ(observed_order(0.1, 1.0, 0.2, 2.0, 0.4, 2.5).behaviour, Behaviour::divergent);
  EXPECT_EQ(observed_order(0.1, 7.0, 0.2, 7.0, 0.4, 7.0 * (1 + 1e-15)).behaviour, Behaviour::constant);
  EXPECT_EQ(observed_order(0.1, NAN, 0.2, 2.0, 0.4, 3.0).behaviour, Behaviour::divergent);
}

TEST(Orders, OfExactErrorsAreTheSlope) {
  const std::vector<double> h{0.4, 0.2, 0.15, 0.1};
  const auto e = manufactured(h, 0.0, 5.0, 1.8);
  for (const double p : pairwise_orders(h, e)) EXPECT_NEAR(p, 1.8, 1e-12);
  EXPECT_NEAR(fitted_order(h, e), 1.8, 1e-12);
}

TEST(Orders, WantSizesFromCoarseToFine) {
  const std::vector<double> rising{0.1, 0.2}, equal{0.1, 0.1}, e{1.0, 2.0}, one{1.0};
  EXPECT_THROW(pairwise_orders(rising, e), ConfigError);
  EXPECT_THROW(fitted_order(equal, e), ConfigError);
  EXPECT_THROW(pairwise_orders(one, one), ConfigError);
  EXPECT_THROW(judge_convergence(rising, e, 2.0), ConfigError);
}

TEST(Convergence, OfACleanSequenceIsAsymptoticAndItsBandsHoldTheLimit) {
  const std::vector<double> h{0.5, 0.35, 0.25, 0.175};
  const auto f = manufactured(h, 3.78, -2.0, 1.5);
  const Convergence s = judge_convergence(h, f, 2.0);
  EXPECT_TRUE(s.asymptotic) << s.remark;
  EXPECT_NEAR(s.order, 1.5, 1e-9);
  EXPECT_NEAR(s.least_squares_order, 1.5, 1e-6);  // golden section on the deviation resolves the square root of round-off
  EXPECT_NEAR(s.least_squares_limit, 3.78, 1e-6);
  EXPECT_EQ(s.safety_factor, 1.25);
  const double distance = std::abs(f.back() - 3.78);
  EXPECT_NEAR(s.gci * f.back(), 1.25 * distance, 1e-9);  // the definition: Fs times the Richardson error
  EXPECT_NEAR(s.least_squares_uncertainty, 1.25 * distance, 1e-5);
}

TEST(Convergence, SaysNotAsymptoticWhenOrdersOfTriplesDisagree) {
  const std::vector<double> h{0.8, 0.4, 0.2, 0.1};
  std::vector<double> f;
  for (const double x : h) f.push_back(1.0 + 0.5 * x + 4.0 * x * x * x);  // orders 2.62 and 2.05, on the way to 1
  const Convergence s = judge_convergence(h, f, 2.0);
  EXPECT_FALSE(s.asymptotic);
  EXPECT_NE(s.remark.find("not asymptotic"), std::string::npos);
}

TEST(Convergence, OscillationIsReportedAndTheBandStillHoldsTheLimit) {
  const std::vector<double> h{0.8, 0.4, 0.2, 0.1};
  std::vector<double> f;
  for (std::size_t i = 0; i < h.size(); ++i) f.push_back(5.0 + (i % 2 ? 1.0 : -1.0) * 0.3 * h[i]);
  const Convergence s = judge_convergence(h, f, 1.0);
  EXPECT_EQ(s.behaviour, Behaviour::oscillating);
  EXPECT_TRUE(std::isnan(s.order));
  EXPECT_FALSE(s.asymptotic);
  EXPECT_EQ(s.safety_factor, 3.0);
  EXPECT_NE(s.remark.find("oscillating"), std::string::npos);
  EXPECT_GT(s.gci * std::abs(f.back()), std::abs(f.back() - 5.0));
  EXPECT_GT(s.least_squares_uncertainty, std::abs(f.back() - 5.0));
}

TEST(Convergence, ThreeGridsAloneNeedTheFormalOrder) {
  const std::vector<double> h{0.4, 0.2, 0.1};
  EXPECT_TRUE(judge_convergence(h, manufactured(h, 1.0, 1.0, 1.9), 2.0).asymptotic);
  const Convergence off = judge_convergence(h, manufactured(h, 1.0, 1.0, 1.2), 2.0);
  EXPECT_FALSE(off.asymptotic);
  EXPECT_TRUE(std::isnan(off.least_squares_uncertainty));
}

TEST(Convergence, AnOrderAboveTheSchemeIsNotCredible) {
  const std::vector<double> h{0.4, 0.2, 0.1};
  const Convergence s = judge_convergence(h, manufactured(h, 1.0, 1.0, 4.0), 1.0);
  EXPECT_EQ(s.safety_factor, 3.0);
  EXPECT_FALSE(s.asymptotic);
}

TEST(Convergence, ThreeGridsWithoutACredibleOrderHaveTheRangeOfTheirValues) {
  const std::vector<double> h{0.4, 0.2, 0.1};
  EXPECT_NEAR(judge_convergence(h, std::vector{1.0, 1.2, 1.1}, 1.5).uncertainty, 3.0 * 0.2, 1e-14);     // zigzag
  EXPECT_NEAR(judge_convergence(h, std::vector{1.0, 1.1, 1.3}, 1.5).uncertainty, 3.0 * 0.3, 1e-14);     // growing differences
  EXPECT_NEAR(judge_convergence(h, std::vector{1.0, 1.9, 1.91}, 1.5).uncertainty, 1.25 * 0.91, 1e-14);  // the finest agree by chance
  const Convergence close = judge_convergence(std::vector{0.3, 0.24, 0.2}, std::vector{1.0, 1.3, 1.4}, 1.0);
  EXPECT_GT(close.order, 1.5);
  EXPECT_NEAR(close.uncertainty, close.gci * 1.4, 1e-14) << "1.25 times the range would be less";
  EXPECT_NEAR(judge_convergence(h, std::vector{1.8, 1.4, 1.2}, 1.5, 0.3).uncertainty, 3.0 * 0.6, 1e-14) << "a difference that is noise";
  const Convergence credible = judge_convergence(h, std::vector{1.8, 1.4, 1.2}, 1.5);
  EXPECT_NEAR(credible.uncertainty, 1.25 * 0.2, 1e-14);
  EXPECT_NEAR(credible.uncertainty, credible.gci * 1.2, 1e-14);
  const Convergence four = judge_convergence(std::vector{0.8, 0.4, 0.2, 0.1}, std::vector{2.6, 1.8, 1.4, 1.2}, 1.5);
  EXPECT_EQ(four.uncertainty, four.least_squares_uncertainty);
}

/// Values whose two finest differ by their noise: the fit over all grids takes the noise for convergence.
TEST(Convergence, AFurtherGridMakesNoNoisyResultMoreCertain) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> scatter(0.0, 0.01);
  const std::vector<double> h{0.5, 0.35, 0.25, 0.175};
  for (int i = 0; i < 200; ++i) {
    auto f = manufactured(h, 1.0, 0.5, 1.0);
    for (double& v : f) v += scatter(random);
    const double noise = 2.0 * std::sqrt(2.0) * 0.01;
    const double of_three = judge_convergence(std::span(h).last(3), std::span<const double>(f).last(3), 1.0, noise).uncertainty;
    EXPECT_GE(judge_convergence(h, f, 1.0, noise).uncertainty, of_three);
  }
}

/// The purpose of an uncertainty: the limit lies inside the band. Eca & Hoekstra aim at 95 %; with Gaussian scatter on five grids
/// the method reaches that for small and for large scatter and dips to 81 % between (2000 trials), where scatter can still pass
/// for a credible order. The GCI of three grids holds the limit less often at every level: the reason to prefer the fit. The uncertainty
/// from the three finest grids lies between: never less often than the GCI.
TEST(Convergence, LeastSquaresBandHoldsTheLimitMoreOftenThanThreeGrids) {
  std::mt19937_64 random(1);
  const std::vector<double> h{0.5, 0.35, 0.25, 0.175, 0.125};
  for (const double noise : {0.0005, 0.01, 0.1}) {
    std::normal_distribution<double> scatter(0.0, noise);
    int inside = 0, inside_gci = 0, inside_three = 0;
    constexpr int trials = 400;
    for (int i = 0; i < trials; ++i) {
      auto f = manufactured(h, 3.78, -1.0, 1.5);
      for (double& v : f) v += scatter(random);
      const Convergence s = judge_convergence(h, f, 2.0);
      inside += std::abs(f.back() - 3.78) <= s.least_squares_uncertainty ? 1 : 0;
      inside_gci += std::abs(f.back() - 3.78) <= s.gci * std::abs(f.back()) ? 1 : 0;
      const Convergence three = judge_convergence(std::span(h).last(3), std::span<const double>(f).last(3), 2.0);
      inside_three += std::abs(f.back() - 3.78) <= three.uncertainty ? 1 : 0;
    }
    EXPECT_GE(inside, inside_gci) << "scatter " << noise;
    EXPECT_GE(inside_three, inside_gci) << "scatter " << noise;
    RecordProperty("held_by_gci_" + std::to_string(noise), inside_gci);
    RecordProperty("held_by_three_grids_" + std::to_string(noise), inside_three);
    EXPECT_GE(inside, (noise == 0.01 ? 0.75 : 0.9) * trials) << "scatter " << noise;  // three standard errors (2 %) below what was seen
  }
}

}  // namespace
}  // namespace mpm
