#include "libmpm/boundary/edge_share.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mpm {
namespace {

// Regression: converged values, the same with 16, 24 and 40 points on the side.
TEST(EdgeShare, DependsOnWhereTheEdgeLiesBetweenTheNodes) {
  const Vec2 inward = Vec2::UnitY();
  EXPECT_NEAR(edge_share({0.3, 0.0}, inward, 1.0), 0.149, 0.003) << "on a row of nodes";
  EXPECT_NEAR(edge_share({0.3, -0.25}, inward, 1.0), 0.237, 0.001);
  EXPECT_NEAR(edge_share({0.3, -0.5}, inward, 1.0), 0.340, 0.001) << "between two rows";
}

TEST(EdgeShare, IsTheSameWhereTheGridIsTheSame) {
  for (const double at : {0.0, 0.2, 0.5, 0.7}) {
    const double here = edge_share({0.3, at}, Vec2::UnitY(), 1.0);
    EXPECT_NEAR(edge_share({0.3, at + 5.0}, Vec2::UnitY(), 1.0), here, 1e-9) << "whole cells";
    EXPECT_NEAR(edge_share({0.3, -at}, -Vec2::UnitY(), 1.0), here, 1e-9) << "mirrored";
    EXPECT_NEAR(edge_share({at, 0.3}, Vec2::UnitX(), 1.0), here, 1e-9) << "along the other axis";
    EXPECT_NEAR(edge_share({0.8, at}, Vec2::UnitY(), 1.0), here, 0.01)
        << "the place across the side scales every point alike; what keeps unseen impulses small does not scale with it";
  }
}

TEST(EdgeShare, IsAShareForAnyDirection) {
  for (int degree = 0; degree < 360; degree += 5) {
    const double angle = degree * std::acos(-1.0) / 180.0;
    const double share = edge_share({0.2, 0.6}, {std::cos(angle), std::sin(angle)}, 0.95);
    EXPECT_GE(share, 0.0) << degree;
    EXPECT_LE(share, 0.5) << degree;
  }
}

}  // namespace
}  // namespace mpm
