#include "validation/harness/norms.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace mpm::validation {
namespace {

TEST(ErrorNorms, AreTheTextbookSums) {
  const std::vector<double> a{1.0, 2.0, 5.0}, b{1.0, 4.0, 4.0};
  const Norms n = error_norms(a, b);
  EXPECT_DOUBLE_EQ(n.l1, 1.0);
  EXPECT_DOUBLE_EQ(n.l2, std::sqrt(5.0 / 3.0));
  EXPECT_DOUBLE_EQ(n.max, 2.0);
}

TEST(Extremes, KeepNotANumberInAnyOrder) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(larger(1.0, 2.0), 2.0);
  EXPECT_EQ(larger(2.0, 1.0), 2.0);
  EXPECT_EQ(smaller(1.0, 2.0), 1.0);
  EXPECT_EQ(smaller(2.0, 1.0), 1.0);
  for (const auto f : {larger, smaller}) {
    EXPECT_TRUE(std::isnan(f(nan, 1.0)));
    EXPECT_TRUE(std::isnan(f(1.0, nan)));
  }
}

TEST(ErrorNorms, WeightsAreVolumes) {
  const std::vector<double> a{1.0, 0.0}, b{0.0, 0.0}, w{3.0, 1.0};
  const Norms n = error_norms(a, b, w);
  EXPECT_DOUBLE_EQ(n.l1, 0.75);
  EXPECT_DOUBLE_EQ(n.l2, std::sqrt(0.75));
}

TEST(ErrorNorms, ANanAnywhereIsANanInEveryNorm) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t where = 0; where < 3; ++where) {
    std::vector<double> a{1.0, 2.0, 3.0};
    const std::vector<double> b{0.0, 0.0, 0.0};
    a[where] = nan;
    const Norms n = error_norms(a, b);
    EXPECT_TRUE(std::isnan(n.l1) && std::isnan(n.l2) && std::isnan(n.max)) << where;
  }
}

TEST(ErrorNorms, LengthsMustAgree) {
  const std::vector<double> a{1.0, 2.0}, b{1.0};
  EXPECT_THROW(error_norms(a, b), ConfigError);
  EXPECT_THROW(error_norms({}, {}), ConfigError);
}

TEST(RelativeError, OfAZeroReferenceIsInfiniteUnlessBothVanish) {
  EXPECT_EQ(relative_error(0.0, 0.0), 0.0);
  EXPECT_TRUE(std::isinf(relative_error(1e-300, 0.0)));
  EXPECT_DOUBLE_EQ(relative_error(-1.0, -2.0), 0.5);
}

}  // namespace
}  // namespace mpm::validation
