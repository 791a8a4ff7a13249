#include "libmpm/boundary/obstacle.hpp"
#include "libmpm/source/body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <type_traits>

#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

ObstacleSpec box_mast(double width = 2.0, double depth = 1.5, double rotation = 0.0) {
  return {.shape = BoxShape{.width = width, .depth = depth, .rotation = rotation}};
}
ObstacleSpec cylinder_mast(double width = 2.0) { return {.shape = CylinderShape{.width = width}}; }
ObstacleSpec wedge_mast(double width = 2.0, double depth = 1.5) { return {.shape = WedgeShape{.width = width, .depth = depth}}; }

std::vector<ObstacleSpec> all_shapes() {
  std::vector<ObstacleSpec> all = {box_mast(2.0, 1.5, -0.3), wedge_mast(1.0, 4.0)};
  for (const testing::TypicalShape& typical : testing::typical_shapes()) all.push_back(typical.obstacle());
  return all;
}

template <ObstacleShape S>
void expect_typical() {
  EXPECT_TRUE(std::ranges::any_of(testing::typical_shapes(), [](const auto& t) { return std::holds_alternative<S>(t.shape); }))
      << S::name << " is missing in tests/support/typical_shapes.hpp";
}

TEST(EveryShape, HasATypicalShape) {
  [&]<class... S>(std::type_identity<std::variant<S...>>) { (expect_typical<S>(), ...); }(std::type_identity<AnyShape>{});
}

TEST(EveryShape, IsTypicalWithinTheSizeThatTestsLeaveItRoomFor) {
  for (const testing::TypicalShape& typical : testing::typical_shapes(1.25)) {
    EXPECT_LE(typical.plan().width, 1.4 * 1.25) << typical.name;
    EXPECT_LE(typical.plan().depth, 1.4 * 1.25) << typical.name;
  }
}

TEST(ObstaclePlans, TouchXZeroWithTheirMostUpstreamPointAndAreCentred) {
  for (const auto& spec : all_shapes()) {
    const auto plan = obstacle_plan(spec);
    double low = 1e9, high = -1e9, left = -1e9, right = 1e9;
    for (const auto& side : plan.sides) {
      low = std::min(low, side.from.x());
      high = std::max(high, side.from.x());
      left = std::max(left, side.from.y());
      right = std::min(right, side.from.y());
    }
    EXPECT_NEAR(low, 0.0, 1e-15);
    EXPECT_DOUBLE_EQ(high, plan.depth);
    EXPECT_NEAR(left, -right, 1e-14);
    EXPECT_DOUBLE_EQ(left, 0.5 * plan.width);
  }
}

TEST(ObstaclePlans, AreConvexWithOutwardUnitNormals) {
  for (const auto& spec : all_shapes()) {
    const auto plan = obstacle_plan(spec);
    for (const auto& side : plan.sides) {
      EXPECT_NEAR(side.normal.norm(), 1.0, 1e-14);
      for (const auto& other : plan.sides) EXPECT_LE(side.normal.dot(other.from - side.from), 1e-12);
    }
  }
}

TEST(ObstaclePlans, HaveTheExtentsOfTheirShape) {
  const auto turned = obstacle_plan(box_mast(2.0, 1.5, 0.5));
  EXPECT_NEAR(turned.depth, 1.5 * std::cos(0.5) + 2.0 * std::sin(0.5), 1e-14);
  EXPECT_NEAR(turned.width, 2.0 * std::cos(0.5) + 1.5 * std::sin(0.5), 1e-14);
  const auto round = obstacle_plan(cylinder_mast());
  EXPECT_DOUBLE_EQ(round.depth, 2.0);
  EXPECT_DOUBLE_EQ(round.width, 2.0);
  const auto wedge = obstacle_plan(wedge_mast());
  EXPECT_DOUBLE_EQ(wedge.depth, 1.5);
  EXPECT_DOUBLE_EQ(wedge.width, 2.0);
}

TEST(ObstaclePlans, KnowWhetherHalfOfThemStandsForTheWhole) {
  EXPECT_TRUE(obstacle_plan(box_mast()).symmetric);
  EXPECT_TRUE(obstacle_plan(cylinder_mast()).symmetric);
  EXPECT_TRUE(obstacle_plan(wedge_mast()).symmetric);
  EXPECT_FALSE(obstacle_plan(box_mast(2.0, 1.5, 0.5)).symmetric);
  EXPECT_FALSE(obstacle_plan(box_mast(1.75, 1.75, 0.5)).symmetric);
  EXPECT_TRUE(obstacle_plan(box_mast(1.75, 1.75, 0.25 * std::numbers::pi)).symmetric);  // a square on its edge
  EXPECT_TRUE(obstacle_plan(box_mast(2.0, 1.5, 0.5 * std::numbers::pi)).symmetric);
}

TEST(ObstacleFronts, DistanceIsTheEuclideanOneOutsideWithItsGradientForANormal) {
  std::mt19937_64 random{5};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto& spec : all_shapes()) {
    const auto plan = obstacle_plan(spec);
    for (int i = 0; i < 100; ++i) {
      const double y = 0.42 * plan.width * unit(random), x = plan.front(y) - 2.0 * std::abs(unit(random));
      // least distance to the whole outline, by points on it
      constexpr double apart = 0.02;
      double least = 1e9;
      for (const auto& side : plan.sides) {
        const int n = static_cast<int>(std::ceil((side.to - side.from).norm() / apart));
        for (int k = 0; k < n; ++k)
          least = std::min(least, (side.from + static_cast<double>(k) / n * (side.to - side.from) - Vec2(x, y)).norm());
      }
      EXPECT_LE(plan.front_distance(x, y), least + 1e-4);  // the polygon is 7.5e-5 m inside the circle
      EXPECT_GE(plan.front_distance(x, y), least - 0.5 * apart - 1e-4);
      constexpr double h = 1e-6;
      const Vec2 n = plan.front_normal(x, y);
      EXPECT_NEAR(n.norm(), 1.0, 1e-12);
      if (x > plan.front(y) - 1e-3) continue;  // across the surface the difference is one-sided
      EXPECT_NEAR((plan.front_distance(x + h, y) - plan.front_distance(x - h, y)) / (2.0 * h), n.x(), 1e-4);
      if (std::abs(y) > 1e-3) {
        EXPECT_NEAR((plan.front_distance(x, y + h) - plan.front_distance(x, y - h)) / (2.0 * h), n.y(), 1e-4);
      }
    }
  }
}

TEST(ObstacleFronts, AreAtDistanceZeroAndNegativeInsideAndBehind) {
  for (const auto& spec : all_shapes()) {
    const auto plan = obstacle_plan(spec);
    for (const double share : {-0.42, -0.2, 0.0, 0.1, 0.4}) {
      const double y = share * plan.width, x = plan.front(y);
      EXPECT_NEAR(plan.front_distance(x, y), 0.0, 1e-12);
      double before = 0.0;
      for (const double into : {0.01, 0.1, 0.5, 2.0, 5.0}) {  // deeper and deeper, also beyond the back
        const double distance = plan.front_distance(x + into, y);
        EXPECT_LT(distance, before);
        before = distance;
      }
    }
  }
}

TEST(ObstacleFronts, OfKnownShapes) {
  const auto wedge = obstacle_plan(wedge_mast(2.0, 1.0));  // half its angle is 45 degrees
  EXPECT_DOUBLE_EQ(wedge.front(0.0), 0.0);
  EXPECT_DOUBLE_EQ(wedge.front(-0.5), 0.5);
  EXPECT_DOUBLE_EQ(wedge.front_distance(-1.0, 0.0), 1.0);  // from the edge
  EXPECT_NEAR(wedge.front_distance(0.0, 0.5), 0.5 / std::numbers::sqrt2, 1e-15);
  EXPECT_NEAR((wedge.front_normal(0.2, 0.5) - Vec2(-1.0, 1.0).normalized()).norm(), 0.0, 1e-15);
  EXPECT_NEAR((wedge.front_normal(-1.0, 0.0) - Vec2(-1.0, 0.0)).norm(), 0.0, 1e-15);
  const auto round = obstacle_plan(cylinder_mast());
  EXPECT_NEAR(round.front(0.6), 0.2, 1e-15);
  EXPECT_NEAR(round.front_distance(-0.5, 0.0), 0.5, 1e-15);
  EXPECT_NEAR((round.front_normal(0.2, 0.6) - Vec2(-0.8, 0.6)).norm(), 0.0, 1e-12);
}

TEST(ObstacleMeetings, BodiesThatReachInAreFoundAndThoseThatTouchAreNot) {
  BodySpec body;
  const auto at = [&](BodySpec::Shape shape, const Vec3& min, const Vec3& max) {
    body.shape = shape;
    body.min = min;
    body.max = max;
    return body;
  };
  constexpr auto box = BodySpec::Shape::box, ball = BodySpec::Shape::sphere, drum = BodySpec::Shape::cylinder;
  const auto flat = box_mast();  // 0 .. 1.5, -1 .. 1
  EXPECT_FALSE(meets_obstacle(at(box, {-1, -1, 0}, {0, 1, 1}), flat));
  EXPECT_TRUE(meets_obstacle(at(box, {-1, -1, 0}, {0.01, 1, 1}), flat));
  EXPECT_TRUE(meets_obstacle(at(box, {0.5, -0.1, 0}, {0.6, 0.1, 1}), flat));  // wholly inside
  const auto wedge = wedge_mast(2.0, 1.0);
  EXPECT_FALSE(meets_obstacle(at(box, {-0.5, 0.5, 0}, {0.4999, 1.5, 1}), wedge));  // its corner is just off the flank
  EXPECT_TRUE(meets_obstacle(at(box, {-0.5, 0.5, 0}, {0.51, 1.5, 1}), wedge));
  const auto slim = wedge_mast(1.0, 1.0);  // its flank is 0.447 m from (0, 0.5)
  EXPECT_FALSE(meets_obstacle(at(drum, {-0.4, 0.1, 0}, {0.4, 0.9, 1}), slim));
  EXPECT_TRUE(meets_obstacle(at(drum, {-0.5, 0.0, 0}, {0.5, 1.0, 1}), slim));
  const auto round = cylinder_mast();  // centre (1, 0), radius 1
  EXPECT_FALSE(meets_obstacle(at(drum, {-1, -0.5, 0}, {0, 0.5, 1}), round));
  EXPECT_TRUE(meets_obstacle(at(drum, {-1, -0.5, 0}, {0.01, 0.5, 1}), round));
  EXPECT_FALSE(meets_obstacle(at(drum, {-0.6, 0.6, 0}, {0.4, 1.6, 1}), round));  // beside the shoulder: boxes meet, circles do not
  auto low = round;
  low.height = 1.0;
  EXPECT_FALSE(meets_obstacle(at(ball, {0, -1, 1}, {2, 1, 3}), low));  // rests on the top
  EXPECT_TRUE(meets_obstacle(at(ball, {0, -1, 0.9}, {2, 1, 2.9}), low));
  EXPECT_FALSE(meets_obstacle(at(ball, {-2.1, -1, 0.9}, {-0.1, 1, 2.9}), low));
}

}  // namespace
}  // namespace mpm
