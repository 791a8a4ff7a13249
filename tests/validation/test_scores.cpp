#include "validation/harness/scores.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm::validation {
namespace {

constexpr double round_off = 1e-14;  // a handful of operations on numbers of order 1

TEST(Scores, MatchValuesComputedByHand) {
  // y = 1, 2, 4 and f = 1, 4, 4: residual sum 4, mean 7/3; in logarithms (unit ln 2): residual 1.
  const std::vector<double> y{1, 2, 4}, f{1, 4, 4};
  const Scores s = compute_scores(y, f);
  EXPECT_NEAR(s.nrmse, std::sqrt(4.0 / 3.0) / (7.0 / 3.0), round_off);
  EXPECT_NEAR(s.rmsle, std::log(2.0) / std::sqrt(3.0), round_off);
  EXPECT_NEAR(s.bias, std::pow(0.5, 1.0 / 3.0), round_off);
}

TEST(Scores, BiasIsAboveOneForPredictionsThatAreTooLow) {
  const std::vector<double> y{2, 4, 6}, f{1, 2, 3};
  EXPECT_NEAR(compute_scores(y, f).bias, 2.0, round_off);
}

TEST(Scores, RefuseWhatTheyAreNotDefinedFor) {
  const std::vector<double> none, one{1.0}, two{1.0, 2.0};
  EXPECT_THROW((void)compute_scores(none, none), ConfigError);
  EXPECT_THROW((void)compute_scores(one, two), ConfigError);
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const std::vector<double> wrong{bad};
    EXPECT_THROW((void)compute_scores(wrong, one), ConfigError);
    EXPECT_THROW((void)compute_scores(one, wrong), ConfigError);
  }
}

}  // namespace
}  // namespace mpm::validation
