#include "libmpm/impact/inflow.hpp"

#include <gtest/gtest.h>

namespace mpm {
namespace {

ConveyorSpec conveyor() {
  ConveyorSpec spec;
  spec.velocity = 10.0;
  spec.flow_height = 2.0;
  return spec;
}

TEST(Inflows, WithoutATableAreThePlugOfTheBelt) {
  const Inflow inflow(conveyor());
  EXPECT_TRUE(inflow.steady());
  EXPECT_FALSE(inflow.sheared());
  for (const double t : {0.0, 0.7, 100.0}) {
    EXPECT_EQ(inflow.velocity(t), 10.0);
    EXPECT_EQ(inflow.flow_height(t), 2.0);
    EXPECT_EQ(inflow.density_ratio(t), 1.0);
    EXPECT_EQ(inflow.travelled(t), 10.0 * t);
  }
  EXPECT_EQ(inflow.shear(0.3), 1.0);
  EXPECT_EQ(inflow.mean_shear(0.2, 0.3), 1.0);
}

TEST(Inflows, AreLinearBetweenTheRowsOfTheirTableAndConstantBeyond) {
  ConveyorSpec spec = conveyor();
  spec.inflow = {{1.0, 8.0, {}, 1.0}, {3.0, {}, 1.0, 1.2}, {4.0, 2.0, 1.0, 1.0}};
  const Inflow inflow(spec);
  EXPECT_FALSE(inflow.steady());
  EXPECT_EQ(inflow.velocity(0.0), 8.0);
  EXPECT_EQ(inflow.velocity(1.0), 8.0);
  EXPECT_DOUBLE_EQ(inflow.velocity(2.0), 9.0);
  EXPECT_EQ(inflow.velocity(3.0), 10.0);
  EXPECT_DOUBLE_EQ(inflow.velocity(3.25), 8.0);
  EXPECT_EQ(inflow.velocity(9.0), 2.0);
  EXPECT_DOUBLE_EQ(inflow.flow_height(2.0), 1.5);
  EXPECT_DOUBLE_EQ(inflow.density_ratio(3.5), 1.1);
  EXPECT_EQ(inflow.fastest(), 10.0);
}

TEST(Inflows, TravelWhatTheirVelocityAddsUpTo) {
  ConveyorSpec spec = conveyor();
  spec.inflow = {{0.5, 8.0, {}, 1.0}, {3.0, {}, 1.0, 1.2}, {4.0, 2.0, 1.0, 1.0}};
  const Inflow inflow(spec);
  EXPECT_EQ(inflow.travelled(0.0), 0.0);
  double sum = 0.0;
  constexpr int n = 60000;
  constexpr double dt = 6.0 / n;
  for (int i = 0; i < n; ++i) {
    sum += inflow.velocity((i + 0.5) * dt) * dt;  // midpoint rule: exact within straight pieces, (dt)^2 at three kinks
    if (i % 1000 == 999) {
      EXPECT_NEAR(inflow.travelled((i + 1) * dt), sum, 1e-7);
    }
  }
}

TEST(ShearedInflows, CarryTheMeanVelocity) {
  for (const double slip : {0.0, 0.3, 0.9}) {
    for (const double exponent : {0.2, 1.0, 2.5}) {
      ConveyorSpec spec = conveyor();
      spec.slip_ratio = slip;
      spec.shear_exponent = exponent;
      const Inflow inflow(spec);
      EXPECT_TRUE(inflow.sheared());
      double rows = 0.0;
      for (int k = 0; k < 14; ++k) rows += inflow.mean_shear(k / 14.0, (k + 1) / 14.0) / 14.0;
      EXPECT_NEAR(rows, 1.0, 1e-14);
      EXPECT_DOUBLE_EQ(inflow.shear(0.0), slip);
      EXPECT_DOUBLE_EQ(inflow.shear(1.0), slip + (1.0 - slip) * (1.0 + exponent));
      EXPECT_EQ(inflow.shear(7.0), inflow.shear(1.0));
      EXPECT_EQ(inflow.shear(-1.0), inflow.shear(0.0));
      EXPECT_NEAR(inflow.mean_shear(0.4, 0.4001), inflow.shear(0.40005), 1e-6);
    }
  }
}

}  // namespace
}  // namespace mpm
