#include "libmpm/boundary/outline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <type_traits>

#include "libmpm/source/body.hpp"
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
    EXPECT_LE(typical.outline().bounds().sizes().maxCoeff(), 1.4 * 1.25) << typical.name;
  }
}

std::vector<Outline> all_outlines() {
  std::vector<Outline> all;
  for (const ObstacleSpec& spec : all_shapes()) all.push_back(outline_of(spec.shape));
  return all;
}

TEST(Outlines, TouchXZeroWithTheirMostUpstreamPointAndAreCentred) {
  for (const Outline& outline : all_outlines()) {
    const Eigen::AlignedBox2d bounds = outline.bounds();
    EXPECT_NEAR(bounds.min().x(), 0.0, 1e-15);
    EXPECT_NEAR(bounds.min().y(), -bounds.max().y(), 1e-14);
    for (const Outline::Side& side : outline.sides()) EXPECT_LE(bounds.exteriorDistance(side.from), 0.0);
  }
}

TEST(Outlines, AreConvexWithOutwardUnitNormals) {
  for (const Outline& outline : all_outlines()) {
    for (const Outline::Side& side : outline.sides()) {
      EXPECT_NEAR(side.normal.norm(), 1.0, 1e-14);
      for (const Outline::Side& other : outline.sides()) EXPECT_LE(side.distance(other.from), 1e-12);
    }
  }
}

TEST(Outlines, HaveTheExtentsOfTheirShape) {
  const auto expect_sizes = [](const ObstacleSpec& spec, double depth, double width) {
    EXPECT_NEAR((outline_of(spec.shape).bounds().sizes() - Vec2(depth, width)).norm(), 0.0, 1e-14);
  };
  expect_sizes(box_mast(2.0, 1.5, 0.5), 1.5 * std::cos(0.5) + 2.0 * std::sin(0.5), 2.0 * std::cos(0.5) + 1.5 * std::sin(0.5));
  expect_sizes(cylinder_mast(), 2.0, 2.0);
  expect_sizes(wedge_mast(), 1.5, 2.0);
}

TEST(Outlines, KnowWhetherHalfOfThemStandsForTheWhole) {
  const auto symmetric = [](const ObstacleSpec& spec) { return outline_of(spec.shape).symmetric(); };
  EXPECT_TRUE(symmetric(box_mast()));
  EXPECT_TRUE(symmetric(cylinder_mast()));
  EXPECT_TRUE(symmetric(wedge_mast()));
  EXPECT_FALSE(symmetric(box_mast(2.0, 1.5, 0.5)));
  EXPECT_FALSE(symmetric(box_mast(1.75, 1.75, 0.5)));
  EXPECT_TRUE(symmetric(box_mast(1.75, 1.75, 0.25 * std::numbers::pi)));  // a square on its edge
  EXPECT_TRUE(symmetric(box_mast(2.0, 1.5, 0.5 * std::numbers::pi)));
}

TEST(Outlines, HaveTheAreaAndTheCentreOfTheirStrips) {
  constexpr int n = 2000;  // strips along the flow; what is left at the ends of the strips is of the order of 1/n^1.5 on a circle
  for (const Outline& outline : all_outlines()) {
    const double strip = outline.bounds().sizes().y() / n;
    double area = 0.0, moment = 0.0;
    for (int i = 0; i < n; ++i) {
      const auto cut = outline.section(outline.bounds().min().y() + strip * (i + 0.5));
      if (!cut) continue;
      area += strip * (cut->high - cut->low);
      moment += 0.5 * strip * (cut->high * cut->high - cut->low * cut->low);
    }
    EXPECT_NEAR(outline.area(), area, 1e-5 * area);
    EXPECT_NEAR(outline.centre().x(), moment / area, 1e-5);
    EXPECT_NEAR(outline.centre().y(), 0.0, 1e-14);
  }
  EXPECT_NEAR(WedgeShape({.width = 1.0, .depth = 3.0}).outline().centre().x(), 2.0, 1e-14);
}

/// The least distance to points that are `apart` on the outline, m.
double distance_to_points(const Outline& outline, const Vec2& x, double apart) {
  double least = 1e9;
  for (const Outline::Side& side : outline.sides()) {
    const int n = static_cast<int>(std::ceil((side.to - side.from).norm() / apart));
    for (int k = 0; k < n; ++k) least = std::min(least, (side.from + static_cast<double>(k) / n * (side.to - side.from) - x).norm());
  }
  return least;
}

TEST(Outlines, DistanceIsTheSignedEuclideanOneToTheNearestPoint) {
  std::mt19937_64 random{4};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const Outline& outline : all_outlines()) {
    int inside = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec2 x(1.0 + 3.0 * unit(random), 2.0 * unit(random));
      const Outline::Nearest near = outline.nearest(x);
      constexpr double apart = 0.02;
      const double least = distance_to_points(outline, x, apart);
      EXPECT_LE(std::abs(near.distance), least + 1e-3) << "the chords are up to 1.5e-4 of the radius inside a circle";
      EXPECT_GE(std::abs(near.distance), least - 0.5 * apart - 1e-3);
      EXPECT_NEAR((x - near.point).norm(), std::abs(near.distance), 1e-12);
      EXPECT_NEAR(outline.distance(x), near.distance, 1e-12);
      EXPECT_NEAR(near.normal.norm(), 1.0, 1e-12);
      const auto cut = outline.section(x.y());
      const bool within = cut && x.x() > cut->low && x.x() < cut->high;
      EXPECT_EQ(near.distance < 0.0, within) << x.transpose();
      if (within) {
        EXPECT_NEAR((near.point + near.distance * near.normal - x).norm(), 0.0, 1e-12) << "along the normal";
      }
      inside += within;
    }
    EXPECT_GT(inside, 10);
  }
}

TEST(Outlines, NormalsAreThoseOfASymmetricOutlineOnItsAxis) {
  for (const ObstacleSpec& spec : {wedge_mast(), box_mast(1.75, 1.75, 0.25 * std::numbers::pi)}) {
    const Outline::Nearest edge = outline_of(spec.shape).nearest({0.05, 0.0});
    EXPECT_LE((edge.normal + Vec2::UnitX()).norm(), 1e-12) << "the mean of both flanks";
  }
  EXPECT_EQ(outline_of(box_mast(2.0, 2.0).shape).nearest({0.5, 0.5}).normal, Vec2(-Vec2::UnitX())) << "the face further upstream";
  EXPECT_EQ(std::abs(outline_of(box_mast(1.0, 4.0).shape).nearest({2.0, 0.0}).normal.y()), 1.0) << "one of two opposite sides";
}

TEST(UprightSolids, DistanceIsThatFromTheNearestFace) {
  const UprightSolid arm{outline_of(box_mast(2.0, 2.0).shape), 1.0, 2.0}, mast{arm.outline};
  const auto expect = [](const UprightSolid& solid, const Vec3& x, double distance, const Vec3& normal) {
    const UprightSolid::Nearest near = solid.nearest(x);
    EXPECT_NEAR(near.distance, distance, 1e-14) << x.transpose();
    EXPECT_EQ(near.normal, normal) << x.transpose();
  };
  expect(arm, {1.0, 0.0, 1.9}, -0.1, Vec3::UnitZ());
  expect(arm, {1.0, 0.0, 1.1}, -0.1, -Vec3::UnitZ());
  expect(arm, {0.05, 0.0, 1.1}, -0.05, -Vec3::UnitX());
  expect(arm, {1.0, 0.0, 0.4}, 0.6, -Vec3::UnitZ());
  expect(arm, {-0.3, 0.0, 0.9}, 0.3, -Vec3::UnitX());
  expect(mast, {0.5, 0.0, -50.0}, -0.5, -Vec3::UnitX());
  EXPECT_EQ(arm.foot(), 1.0);
  EXPECT_EQ(mast.foot(), 0.0);
}

TEST(ObstacleFronts, DistanceIsTheEuclideanOneOutsideWithItsGradientForANormal) {
  std::mt19937_64 random{5};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const Outline& outline : all_outlines()) {
    const auto distance = [&](double x, double y) { return outline.nearest_of_front({x, y}).distance; };
    for (int i = 0; i < 100; ++i) {
      const double y = 0.42 * outline.bounds().sizes().y() * unit(random), front = outline.section(y).value().low;
      const double x = front - 2.0 * std::abs(unit(random));
      constexpr double apart = 0.02;
      const double least = distance_to_points(outline, {x, y}, apart);
      EXPECT_LE(distance(x, y), least + 1e-4);  // the polygon is 7.5e-5 m inside the circle
      EXPECT_GE(distance(x, y), least - 0.5 * apart - 1e-4);
      constexpr double h = 1e-6;
      const Vec2 n = outline.nearest_of_front({x, y}).normal;
      EXPECT_NEAR(n.norm(), 1.0, 1e-12);
      if (x > front - 1e-3) continue;  // across the surface the difference is one-sided
      EXPECT_NEAR((distance(x + h, y) - distance(x - h, y)) / (2.0 * h), n.x(), 1e-4);
      if (std::abs(y) > 1e-3) {
        EXPECT_NEAR((distance(x, y + h) - distance(x, y - h)) / (2.0 * h), n.y(), 1e-4);
      }
    }
  }
}

TEST(ObstacleFronts, AreAtDistanceZeroAndNegativeInsideAndBehind) {
  for (const Outline& outline : all_outlines()) {
    for (const double share : {-0.42, -0.2, 0.0, 0.1, 0.4}) {
      const double y = share * outline.bounds().sizes().y(), x = outline.section(y).value().low;
      EXPECT_NEAR(outline.nearest_of_front({x, y}).distance, 0.0, 1e-12);
      double before = 0.0;
      for (const double into : {0.01, 0.1, 0.5, 2.0, 5.0}) {  // deeper and deeper, also beyond the back
        const double distance = outline.nearest_of_front({x + into, y}).distance;
        EXPECT_LT(distance, before);
        before = distance;
      }
    }
  }
}

TEST(ObstacleFronts, OfKnownShapes) {
  const Outline wedge = outline_of(wedge_mast(2.0, 1.0).shape);  // half its angle is 45 degrees
  EXPECT_DOUBLE_EQ(wedge.section(0.0)->low, 0.0);
  EXPECT_DOUBLE_EQ(wedge.section(-0.5)->low, 0.5);
  EXPECT_DOUBLE_EQ(wedge.nearest_of_front({-1.0, 0.0}).distance, 1.0);  // from the edge
  EXPECT_NEAR(wedge.nearest_of_front({0.0, 0.5}).distance, 0.5 / std::numbers::sqrt2, 1e-15);
  EXPECT_NEAR((wedge.nearest_of_front({0.2, 0.5}).normal - Vec2(-1.0, 1.0).normalized()).norm(), 0.0, 1e-15);
  EXPECT_NEAR((wedge.nearest_of_front({-1.0, 0.0}).normal - Vec2(-1.0, 0.0)).norm(), 0.0, 1e-15);
  const Outline round = outline_of(cylinder_mast().shape);
  EXPECT_NEAR(round.section(0.6)->low, 0.2, 1e-15);
  EXPECT_NEAR(round.nearest_of_front({-0.5, 0.0}).distance, 0.5, 1e-15);
  EXPECT_NEAR((round.nearest_of_front({0.2, 0.6}).normal - Vec2(-0.8, 0.6)).norm(), 0.0, 1e-12);
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
  EXPECT_FALSE(meets_solid(at(box, {-1, -1, 0}, {0, 1, 1}), flat.solid()));
  EXPECT_TRUE(meets_solid(at(box, {-1, -1, 0}, {0.01, 1, 1}), flat.solid()));
  EXPECT_TRUE(meets_solid(at(box, {0.5, -0.1, 0}, {0.6, 0.1, 1}), flat.solid()));  // wholly inside
  const auto wedge = wedge_mast(2.0, 1.0);
  EXPECT_FALSE(meets_solid(at(box, {-0.5, 0.5, 0}, {0.4999, 1.5, 1}), wedge.solid()));  // its corner is just off the flank
  EXPECT_TRUE(meets_solid(at(box, {-0.5, 0.5, 0}, {0.51, 1.5, 1}), wedge.solid()));
  const auto slim = wedge_mast(1.0, 1.0);  // its flank is 0.447 m from (0, 0.5)
  EXPECT_FALSE(meets_solid(at(drum, {-0.4, 0.1, 0}, {0.4, 0.9, 1}), slim.solid()));
  EXPECT_TRUE(meets_solid(at(drum, {-0.5, 0.0, 0}, {0.5, 1.0, 1}), slim.solid()));
  const auto round = cylinder_mast();  // centre (1, 0), radius 1
  EXPECT_FALSE(meets_solid(at(drum, {-1, -0.5, 0}, {0, 0.5, 1}), round.solid()));
  EXPECT_TRUE(meets_solid(at(drum, {-1, -0.5, 0}, {0.01, 0.5, 1}), round.solid()));
  EXPECT_FALSE(meets_solid(at(drum, {-0.6, 0.6, 0}, {0.4, 1.6, 1}), round.solid()));  // beside the shoulder: boxes meet, circles do not
  auto low = round;
  low.height = 1.0;
  EXPECT_FALSE(meets_solid(at(ball, {0, -1, 1}, {2, 1, 3}), low.solid()));  // rests on the top
  EXPECT_TRUE(meets_solid(at(ball, {0, -1, 0.9}, {2, 1, 2.9}), low.solid()));
  EXPECT_FALSE(meets_solid(at(ball, {-2.1, -1, 0.9}, {-0.1, 1, 2.9}), low.solid()));
  auto arm = round;
  arm.base = 1.0;
  EXPECT_FALSE(meets_solid(at(box, {-1, -1, 0}, {3, 1, 1}), arm.solid()));  // below it
  EXPECT_TRUE(meets_solid(at(box, {-1, -1, 0}, {3, 1, 1.1}), arm.solid()));
  EXPECT_FALSE(meets_solid(at(ball, {0, -1, -1}, {2, 1, 1}), arm.solid()));
  EXPECT_TRUE(meets_solid(at(ball, {0, -1, -0.9}, {2, 1, 1.1}), arm.solid()));
}

}  // namespace
}  // namespace mpm
