#include "libmpm/base/bspline.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace mpm {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Offsets over all of [1/2, 3/2], both ends included.
template <class F>
void for_many_offsets(F&& f) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> offset(0.5, 1.5);
  for (const double x : {0.5, 1.0, 1.5, std::nextafter(0.5, 1.0), std::nextafter(1.5, 1.0)}) f(x);
  for (int i = 0; i < 10000; ++i) f(offset(random));
}

TEST(Bspline, WeightsArePositiveAndSumToOne) {
  for_many_offsets([](double f) {
    const auto w = bspline_weights(f);
    EXPECT_GE(w.n0, 0.0);
    EXPECT_GE(w.n1, 0.5);  // the middle node has 1/2 to 3/4
    EXPECT_GE(w.n2, 0.0);
    EXPECT_NEAR(w.n0 + w.n1 + w.n2, 1.0, 4.0 * eps);  // a handful of roundings of numbers below 1
  });
}

TEST(Bspline, FirstMomentVanishesAndSecondMomentIsAQuarter) {
  for_many_offsets([](double f) {
    const auto w = bspline_weights(f);
    const double r[] = {0.0 - f, 1.0 - f, 2.0 - f};
    EXPECT_NEAR(w.n0 * r[0] + w.n1 * r[1] + w.n2 * r[2], 0.0, 8.0 * eps);  // terms up to 3/4
    EXPECT_NEAR(w.n0 * r[0] * r[0] + w.n1 * r[1] * r[1] + w.n2 * r[2] * r[2], 0.25, 8.0 * eps);
  });
}

TEST(Bspline, BothNeighboursOfATieGiveTheSameNodalWeights) {
  const auto from_left = bspline_weights(1.5), from_right = bspline_weights(0.5);  // nodes b-1, b, b+1 and b, b+1, b+2
  EXPECT_EQ(from_left.n0, 0.0);
  EXPECT_EQ(from_left.n1, from_right.n0);
  EXPECT_EQ(from_left.n2, from_right.n1);
  EXPECT_EQ(from_right.n2, 0.0);
}

TEST(Bspline, TailIsTheIntegralOfTheWeight) {
  const auto weight = [](double y) {  // of a node at a distance y: all three branches
    return y < -0.5 ? bspline_weights(-y).n0 : y < 0.5 ? bspline_weights(1.0 - y).n1 : bspline_weights(2.0 - y).n2;
  };
  EXPECT_EQ(bspline_tail(1.5), 0.0);
  EXPECT_EQ(bspline_tail(2.0), 0.0);
  EXPECT_EQ(bspline_tail(-2.0), 1.0);
  const int steps = 3000;
  double integral = 0.0;
  for (int i = steps - 1; i >= 0; --i) {  // midpoint rule: h^2/24 of the change of slope
    const double h = 3.0 / steps, y = -1.5 + h * i;
    integral += h * weight(y + 0.5 * h);
    EXPECT_NEAR(bspline_tail(y), integral, 2e-7) << y;
  }
}

TEST(Bspline, BaseNodeLeavesAnOffsetBetweenHalfAndThreeHalvesOnBothSidesOfTheOrigin) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> coordinate(-50.0, 50.0);
  for (int i = 0; i < 10000; ++i) {
    const double x = i < 400 ? 0.25 * (i - 200) : coordinate(random);  // also on nodes, on ties and between
    const double f = x - base_node(x);
    EXPECT_GE(f, 0.5) << x;
    EXPECT_LE(f, 1.5) << x;
  }
}

TEST(Bspline, LanesGiveWhatTheScalarGives) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> offset(0.5, 1.5);
  for (int n = 0; n < 100; ++n) {
    Lanes f;
    for (int i = 0; i < lanes_of<Lanes>; ++i) f[i] = offset(random);
    const auto w = bspline_weights(f);
    for (int i = 0; i < lanes_of<Lanes>; ++i) {
      const auto s = bspline_weights(static_cast<double>(f[i]));
      EXPECT_NEAR(w.n0[i], s.n0, eps);  // a contracted multiply-add may round once less
      EXPECT_NEAR(w.n1[i], s.n1, eps);
      EXPECT_NEAR(w.n2[i], s.n2, eps);
    }
  }
}

}  // namespace
}  // namespace mpm
