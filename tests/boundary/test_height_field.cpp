
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "libmpm/boundary/terrain.hpp"
#include "support/ground.hpp"

namespace mpm {
namespace {

using testing::ground_field;

/// Places inside, on points, on lines between them, and up to two spacings beyond the raster.
std::vector<Vec2> places(double half_width) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> anywhere(-half_width - 2.0, half_width + 2.0);
  std::vector<Vec2> all = {Vec2(0.0, 0.0), Vec2(1.0, 0.5), Vec2(half_width, -half_width), Vec2(-half_width, 0.3)};
  for (int n = 0; n < 200; ++n) all.emplace_back(anywhere(random), anywhere(random));
  return all;
}

TEST(HeightField, OfEqualHeightsIsThisHeightToTheLastBit) {
  for (const double height : {0.0, 0.1, -1234.567}) {
    const auto field = ground_field([&](double, double) { return height; });
    for (const Vec2& at : places(8.0)) {
      EXPECT_EQ(field->at(at).height, height);
      EXPECT_EQ(field->at(at).slope, Vec2(0.0, 0.0));
      EXPECT_EQ(field->at(at).normal(), Vec3(0.0, 0.0, 1.0));
    }
  }
}

TEST(HeightField, IsExactForPlanesInsideAndBeyondTheRaster) {
  const auto plane = [](double x, double y) { return 0.7 - 0.3 * x + 0.45 * y; };
  const auto field = ground_field(plane);
  for (const Vec2& at : places(8.0)) {
    EXPECT_NEAR(field->at(at).height, plane(at.x(), at.y()), 1e-13);  // rounding of heights of 10 m
    EXPECT_NEAR((field->at(at).slope - Vec2(-0.3, 0.45)).norm(), 0.0, 1e-13);
  }
}

TEST(HeightField, IsExactForQuadraticSurfacesAwayFromTheEdge) {
  const auto bowl = [](double x, double y) { return 0.1 * x * x - 0.05 * y * y + 0.02 * x * y + 0.3 * x; };
  const auto field = ground_field(bowl);
  for (const Vec2& at : places(8.0)) {
    if (at.cwiseAbs().maxCoeff() > 7.0) continue;
    EXPECT_NEAR(field->at(at).height, bowl(at.x(), at.y()), 1e-13);
    EXPECT_NEAR(field->at(at).slope.x(), 0.2 * at.x() + 0.02 * at.y() + 0.3, 1e-13);
    EXPECT_NEAR(field->at(at).slope.y(), -0.1 * at.y() + 0.02 * at.x(), 1e-13);
  }
}

std::shared_ptr<const HeightField> random_field() {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> height(-1.0, 2.0);
  return ground_field([&](double, double) { return height(random); });
}

TEST(HeightField, PassesThroughItsPointsWithASlopeThatIsTheDerivativeAndContinuous) {
  const auto field = random_field();
  const HeightField::Points& points = field->points();
  for (std::size_t j = 0; j < points.rows; ++j) {
    for (std::size_t i = 0; i < points.columns; ++i) {
      const Vec2 at = points.first + Vec2(static_cast<double>(i), static_cast<double>(j));
      EXPECT_NEAR(field->at(at).height, points.height[j * points.columns + i], 1e-14);
    }
  }
  constexpr double h = 1e-6;
  for (const Vec2& at : places(5.9)) {  // inside
    for (int axis = 0; axis < 2; ++axis) {
      const Vec2 step = h * Vec2::Unit(axis);
      const double difference = (field->at(at + step).height - field->at(at - step).height) / (2.0 * h);
      // second derivatives of up to 30 / m across a line between cells: half of it times h
      EXPECT_NEAR(field->at(at).slope[axis], difference, 3e-5) << at.transpose();
      EXPECT_NEAR((field->at(at + step).slope - field->at(at - step).slope).norm(), 0.0, 1e-4);
    }
  }
}

TEST(HeightField, StaysWithinItsBounds) {
  const auto field = random_field();
  for (const Vec2& at : places(6.0)) {
    EXPECT_GE(field->at(at).height, field->lowest());
    EXPECT_LE(field->at(at).height, field->highest());
  }
  EXPECT_LT(field->highest() - field->lowest(), 1.6 * 3.0);  // 0.29 of the range on both sides
}

Terrain slope_of(double gradient, Contact contact, double friction = 0.0) {
  return {.field = ground_field([&](double x, double) { return gradient * x; }), .contact = contact, .friction = friction};
}

TEST(Terrain, CoversWhatIsBelowItsSurfaceWhereverItIsMoved) {
  Terrain ground = slope_of(0.5, Contact::separable);
  EXPECT_TRUE(ground.covers(Vec3(2.0, 0.0, 0.99), 0.0));
  EXPECT_FALSE(ground.covers(Vec3(2.0, 0.0, 1.01), 0.0));
  EXPECT_TRUE(ground.reaches(Vec3(2.0, 0.0, 0.9), Vec3(3.0, 1.0, 1.9), 0.0));
  EXPECT_FALSE(ground.reaches(Vec3(2.0, 0.0, 7.0), Vec3(3.0, 1.0, 8.0), 0.0));
  ground.translate(Vec3(1.0, 0.0, 0.25));  // now 0.5 (x - 1) + 0.25
  EXPECT_TRUE(ground.covers(Vec3(2.0, 0.0, 0.74), 0.0));
  EXPECT_FALSE(ground.covers(Vec3(2.0, 0.0, 0.76), 0.0));
  EXPECT_EQ(ground.reference_point(), Vec3(1.0, 0.0, 0.25));
}

TEST(Terrain, TakesTheVelocityAlongItsNormalAndFrictionInItsPlane) {
  const double gradient = 0.5, mu = 0.2;
  const Vec3 normal = Vec3(-gradient, 0.0, 1.0).normalized(), along = Vec3(1.0, 0.0, gradient).normalized();
  const Vec3 node(1.0, 2.0, 0.0), v = 3.0 * along + 2.0 * Vec3::UnitY() - 1.5 * normal;
  const Vec3 slid = slope_of(gradient, Contact::separable).constrain(node, v, 0.0);
  EXPECT_NEAR((slid - (3.0 * along + 2.0 * Vec3::UnitY())).norm(), 0.0, 1e-14);
  const Vec3 rubbed = slope_of(gradient, Contact::separable, mu).constrain(node, v, 0.0);
  EXPECT_NEAR((slid - rubbed).norm(), mu * 1.5, 1e-14);
  EXPECT_NEAR(rubbed.cross(slid).norm(), 0.0, 1e-13);
  const Vec3 up = 3.0 * along + 1.5 * normal;
  EXPECT_EQ(slope_of(gradient, Contact::separable, mu).constrain(node, up, 0.0), up);
}

TEST(Terrain, MovesAsABeltThatFollowsTheGround) {
  Terrain belt = slope_of(0.5, Contact::no_slip);
  belt.speed = 4.0;
  EXPECT_NEAR((belt.surface_velocity(Vec3(1.0, 0.0, 0.0), 0.0) - Vec3(4.0, 0.0, 2.0)).norm(), 0.0, 1e-14);
  EXPECT_NEAR((belt.constrain(Vec3(1.0, 0.0, 0.0), Vec3::Zero(), 0.0) - Vec3(4.0, 0.0, 2.0)).norm(), 0.0, 1e-14);
}

}  // namespace
}  // namespace mpm
