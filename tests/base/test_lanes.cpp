#include "libmpm/base/lanes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using namespace mpm;

LaneMask mask_of(int bits) {
  LaneMask m{};
  for (int i = 0; i < lane_count; ++i) m[i] = (bits >> i) & 1 ? -1 : 0;
  return m;
}

TEST(Lanes, AnyAndAllSeeEveryLane) {
  for (int bits = 0; bits < 256; ++bits) {
    EXPECT_EQ(any(mask_of(bits)), bits != 0) << bits;
    EXPECT_EQ(all(mask_of(bits)), bits == 255) << bits;
  }
}

/// Largest error over magnitudes 1e-300 to `largest` of both signs, in units of the exact value's last place, against long double.
template <class F, class Exact>
double worst_ulp(F f, Exact exact, double largest, double most_negative) {
  double worst = 0.0;
  for (double size = 1e-300; size < largest; size *= size < 1e-20 ? 1e7 : 1.0037) {
    Lanes x;
    for (int i = 0; i < lane_count; ++i) {
      const double value = size * (1.0 + 0.1 * i) * (i % 2 ? -1.0 : 1.0);
      x[i] = value > most_negative ? value : -value;
    }
    const Lanes y = f(x);
    for (int i = 0; i < lane_count; ++i) {
      const long double reference = exact(static_cast<long double>(x[i]));
      worst = std::max(worst, static_cast<double>(std::fabs((y[i] - reference) / reference)) / std::numeric_limits<double>::epsilon());
    }
  }
  return worst;
}

// libmvec promises 4 ulp; a subtraction of 1 at the edge of the series (|x| = 0.35) multiplies its error by at most e^0.35/(1 - e^-0.35)
// = 4.8 on the negative side; sinh's by 1.1.
TEST(Lanes, ExpAgreesWithLongDouble) {
  EXPECT_LE(worst_ulp([](const Lanes& x) { return exp(x); }, [](long double x) { return std::exp(x); }, 300.0, -1e9), 4.0);
}
TEST(Lanes, LogAgreesWithLongDouble) {
  // Away from 1, where the value itself vanishes.
  double worst = 0.0;
  for (double x = 1e-300; x < 1e300; x *= 3.7) {
    if (std::fabs(std::log(x)) < 0.1) continue;
    const Lanes y = log(broadcast<Lanes>(x));
    worst = std::max(worst, static_cast<double>(std::fabs(y[3] / std::log(static_cast<long double>(x)) - 1.0L)));
  }
  EXPECT_LE(worst, 4.0 * std::numeric_limits<double>::epsilon());
}
TEST(Lanes, Expm1KeepsRelativePrecision) {
  EXPECT_LE(worst_ulp([](const Lanes& x) { return expm1(x); }, [](long double x) { return std::expm1(x); }, 100.0, -1e9), 4.0 * 4.8);
}
TEST(Lanes, Log1pKeepsRelativePrecision) {
  // Beyond the series 1 + x is rounded: half an ulp over log(1 - 0.35) (1 - 0.35), a factor 3.6; and nearer to -1 its conditioning.
  EXPECT_LE(worst_ulp([](const Lanes& x) { return log1p(x); }, [](long double x) { return std::log1p(x); }, 100.0, -0.7), 4.0 + 3.6);
}
TEST(Lanes, SinhKeepsRelativePrecision) {
  EXPECT_LE(worst_ulp([](const Lanes& x) { return sinh(x); }, [](long double x) { return std::sinh(x); }, 300.0, -1e9), 4.0 * 1.6);
}

TEST(Lanes, ALaneDoesNotDisturbItsNeighbours) {
  // One lane outside a series' radius, or NaN, sends the group down the general path: the others keep their precision.
  Lanes x = broadcast<Lanes>(1e-9);
  x[2] = 3.0, x[5] = std::numeric_limits<double>::quiet_NaN();
  for (const Lanes& y : {expm1(x), log1p(x), sinh(x)}) {
    EXPECT_NEAR(y[0], 1e-9, 1e-18);  // second-order term
    EXPECT_TRUE(std::isnan(y[5]));
  }
  EXPECT_NEAR(sinh(x)[2], std::sinh(3.0), 4e-15 * std::sinh(3.0));
}

TEST(Lanes, SaturatedBytesKeepWhatFitsAndClampTheRest) {
  const LaneMask x = {0, 3, -4, -1, 127, 128, -129, std::numeric_limits<std::int64_t>::min()};
  const std::int8_t expected[8] = {0, 3, -4, -1, 127, 127, -128, -128};
  const std::uint64_t bytes = saturated_bytes(x);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(static_cast<std::int8_t>(bytes >> (8 * i) & 0xFFU), expected[i]) << i;
}

TEST(Lanes, AbsoluteValueOfEveryKind) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Lanes y = abs(Lanes{-1.5, 1.5, -0.0, 0.0, -infinity, infinity, -5e-324, std::numeric_limits<double>::quiet_NaN()});
  const double expected[7] = {1.5, 1.5, 0.0, 0.0, infinity, infinity, 5e-324};
  for (int i = 0; i < 7; ++i) EXPECT_EQ(y[i], expected[i]) << i;
  EXPECT_FALSE(std::signbit(y[2]));
  EXPECT_TRUE(std::isnan(y[7]));
}

}  // namespace
