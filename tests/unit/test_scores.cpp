#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "mpm/error.hpp"
#include "mpm/impact/scores.hpp"

namespace mpm {
namespace {

constexpr double round_off = 1e-14;  // a handful of operations on numbers of order 1

TEST(Scores, MatchValuesComputedByHand) {
  // y = 1, 2, 4 and f = 1, 4, 4: residual sum 4, mean 7/3, total 14/3; in logarithms (unit ln 2): residual 1, mean 1, total 2.
  const std::vector<double> y{1, 2, 4}, f{1, 4, 4};
  const Scores s = compute_scores(y, f);
  EXPECT_NEAR(s.r2, 1.0 - 4.0 / (14.0 / 3.0), round_off);
  EXPECT_NEAR(s.r2_log, 0.5, round_off);
  EXPECT_NEAR(s.nrmse, std::sqrt(4.0 / 3.0) / (7.0 / 3.0), round_off);
  EXPECT_NEAR(s.rmsle, std::log(2.0) / std::sqrt(3.0), round_off);
  EXPECT_NEAR(s.bias, std::pow(0.5, 1.0 / 3.0), round_off);
  EXPECT_NEAR(s.fraction_10, 2.0 / 3.0, round_off);
  EXPECT_NEAR(s.fraction_25, 2.0 / 3.0, round_off);
}

TEST(Scores, OfPerfectPredictionAreOneAndZero) {
  const std::vector<double> y{1.5, 2.5, 7.0};
  const Scores s = compute_scores(y, y);
  EXPECT_EQ(s.r2, 1.0);
  EXPECT_EQ(s.r2_log, 1.0);
  EXPECT_EQ(s.nrmse, 0.0);
  EXPECT_EQ(s.rmsle, 0.0);
  EXPECT_EQ(s.bias, 1.0);
  EXPECT_EQ(s.fraction_10, 1.0);
  EXPECT_EQ(s.fraction_25, 1.0);
}

TEST(Scores, OfPredictingTheMeanHaveNoDetermination) {
  const std::vector<double> y{1, 2, 3}, f{2, 2, 2};
  EXPECT_NEAR(compute_scores(y, f).r2, 0.0, round_off);
}

TEST(Scores, BiasIsAboveOneForPredictionsThatAreTooLow) {
  const std::vector<double> y{2, 4, 6}, f{1, 2, 3};
  EXPECT_NEAR(compute_scores(y, f).bias, 2.0, round_off);
}

TEST(Scores, TolerancesAreRelativeToTheSimulatedValueAndInclusive) {
  // Differences 1/8, 1/4 and 1/2 of y, exact in binary; 25 % counts as within 25 %.
  const std::vector<double> y{8, 8, 8, 8}, f{8, 9, 6, 12};
  const Scores s = compute_scores(y, f);
  EXPECT_EQ(s.fraction_10, 0.25);
  EXPECT_EQ(s.fraction_25, 0.75);
}

TEST(Scores, DoNotDependOnTheUnit) {
  const std::vector<double> y{1, 2, 4, 3}, f{1.1, 1.7, 4.4, 3.2}, y_cm{100, 200, 400, 300}, f_cm{110, 170, 440, 320};
  const Scores a = compute_scores(y, f), b = compute_scores(y_cm, f_cm);
  EXPECT_NEAR(a.r2, b.r2, round_off);
  EXPECT_NEAR(a.r2_log, b.r2_log, round_off * 10);  // logarithms near 6 lose one digit
  EXPECT_NEAR(a.nrmse, b.nrmse, round_off);
  EXPECT_NEAR(a.rmsle, b.rmsle, round_off);
  EXPECT_NEAR(a.bias, b.bias, round_off);
}

TEST(Scores, DeterminationOfEqualValuesIsNotANumber) {
  const std::vector<double> y{0.1, 0.1, 0.1}, f{0.1, 0.2, 0.1};
  const Scores s = compute_scores(y, f);
  EXPECT_TRUE(std::isnan(s.r2));
  EXPECT_TRUE(std::isnan(s.r2_log));
  EXPECT_GT(s.rmsle, 0.0);
}

TEST(Scores, RefuseWhatTheyAreNotDefinedFor) {
  const std::vector<double> none, one{1.0}, two{1.0, 2.0}, zero{0.0}, negative{-1.0}, nan{std::nan("")},
      infinite{std::numeric_limits<double>::infinity()};
  EXPECT_THROW((void)compute_scores(none, none), ConfigError);
  EXPECT_THROW((void)compute_scores(one, two), ConfigError);
  for (const auto& bad : {zero, negative, nan, infinite}) {
    EXPECT_THROW((void)compute_scores(bad, one), ConfigError);
    EXPECT_THROW((void)compute_scores(one, bad), ConfigError);
  }
}

TEST(ScoresByGroup, AreTheScoresOfEachGroupsRowsByRisingValue) {
  const std::vector<double> key{3, 1, 3, 1 + 5e-7, 0}, y{1, 2, 4, 3, 7}, f{2, 2, 4, 4, 7};
  const auto groups = scores_by_group(key, y, f);
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].at, 0.0);
  EXPECT_EQ(groups[1].at, 1.0);
  EXPECT_EQ(groups[2].at, 3.0);
  EXPECT_EQ(groups[0].rows, 1u);
  EXPECT_EQ(groups[1].rows, 2u);
  EXPECT_EQ(groups[0].scores.rmsle, 0.0);
  const std::vector<double> y1{2, 3}, f1{2, 4}, y3{1, 4}, f3{2, 4};
  EXPECT_EQ(groups[1].scores.nrmse, compute_scores(y1, f1).nrmse);
  EXPECT_EQ(groups[2].scores.rmsle, compute_scores(y3, f3).rmsle);
  EXPECT_THROW((void)scores_by_group(y1, y, f), ConfigError);
}

}  // namespace
}  // namespace mpm
