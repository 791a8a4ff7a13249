#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/impact/measure.hpp"

namespace mpm {
namespace {

// Round-off of a 13-term dot product of numbers of order 1, with room for the QR factorisation.
constexpr double round_off = 1e-13;

TEST(SavitzkyGolay, LeavesPolynomialsUpToItsOrderUnchangedIncludingTheEnds) {
  for (const int window : {3, 5, 13}) {
    std::vector<double> parabola(20);
    for (int i = 0; i < 20; ++i) parabola[i] = 1.0 - 0.3 * i + 0.02 * i * i;
    const auto smooth = savitzky_golay(parabola, window, 2);
    for (int i = 0; i < 20; ++i) EXPECT_NEAR(smooth[i], parabola[i], round_off * 10) << "window " << window << ", place " << i;
  }
}

TEST(SavitzkyGolay, HasThePublishedWeightsOfThirteenPointsAndOrderTwo) {
  // Savitzky and Golay (1964), Table I: (-11, 0, 9, 16, 21, 24, 25, 24, 21, 16, 9, 0, -11) / 143.
  const double weights[] = {-11, 0, 9, 16, 21, 24, 25, 24, 21, 16, 9, 0, -11};
  for (int k = 0; k < 13; ++k) {
    std::vector<double> impulse(27, 0.0);
    impulse[13 - 6 + k] = 1.0;
    EXPECT_NEAR(savitzky_golay(impulse, 13, 2)[13], weights[k] / 143.0, round_off);
  }
}

TEST(SavitzkyGolay, EndsAreTheFitToTheFirstAndLastWindow) {
  // Five points, straight line: least-squares line through (0,0) (1,0) (2,0) (3,0) (4,1) is -0.2 + 0.2 x.
  const std::vector<double> y{0, 0, 0, 0, 1};
  const auto smooth = savitzky_golay(y, 5, 1);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(smooth[i], -0.2 + 0.2 * i, round_off);
}

TEST(SavitzkyGolay, MirroredInputGivesMirroredOutput) {
  std::vector<double> y, reversed;
  for (int i = 0; i < 30; ++i) y.push_back(std::sin(0.9 * i) + 0.1 * i);
  reversed.assign(y.rbegin(), y.rend());
  const auto a = savitzky_golay(y, 13, 2), b = savitzky_golay(reversed, 13, 2);
  for (int i = 0; i < 30; ++i) EXPECT_NEAR(a[i], b[29 - i], round_off * 10);
}

TEST(SavitzkyGolay, RefusesWindowsThatDoNotFit) {
  const std::vector<double> y(10, 1.0);
  EXPECT_THROW((void)savitzky_golay(y, 4, 2), ConfigError);
  EXPECT_THROW((void)savitzky_golay(y, 11, 2), ConfigError);
  EXPECT_THROW((void)savitzky_golay(y, 3, 3), ConfigError);
  EXPECT_THROW((void)savitzky_golay(y, -1, 0), ConfigError);
  EXPECT_THROW((void)savitzky_golay(y, 3, -1), ConfigError);
}

}  // namespace
}  // namespace mpm
