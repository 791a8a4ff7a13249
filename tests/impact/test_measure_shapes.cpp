#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "libmpm/impact/measure.hpp"
#include "libmpm/observe/pressure_profile.hpp"
#include "libmpm/observe/runup.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

constexpr double H = 1.75, w = 1.75, rho0 = 300.0, dx = 0.25;
ImpactGeometry before(const AnyShape& shape, std::optional<double> height = {}, double base = 0.0) {
  const ObstacleSpec spec{.shape = shape, .height = height, .base = base};
  ImpactGeometry geometry = paper_geometry(H, w, dx, rho0, false);
  geometry.set_obstacle(spec);
  return geometry;
}

TEST(ImpactGeometryOfShapes, IsThePapersForItsBox) {
  const auto box = before(BoxShape{});
  EXPECT_EQ(box.box_area, 2.0 * 0.75 * 0.625);
  EXPECT_EQ(box.impact_top(), H);
  EXPECT_EQ(before(BoxShape{}, 1.0).impact_top(), 1.0);
  EXPECT_EQ(before(BoxShape{}, 9.0).impact_top(), H);
  EXPECT_EQ(box.front(0.3), 0.0);
}

TEST(ImpactGeometryOfShapes, BeginsAtTheFootOfAnObstacleAboveTheGround) {
  const auto arm = before(BoxShape{}, 5.0, 2.0);
  EXPECT_EQ(arm.impact_top(), 2.0 + H);
  EXPECT_EQ(before(BoxShape{}, 3.0, 2.0).impact_top(), 3.0);
  EXPECT_TRUE(arm.in_profile_box({-0.1, 0.0, 2.0}));
  EXPECT_FALSE(arm.in_profile_box({-0.1, 0.0, 1.99})) << "the flow that passes below";
  PressureProfile profile(arm);
  for (double z = 0.06; z < 5.0; z += 0.1) profile.add({-0.1, 0.0, z}, -(z < 2.0 ? 9.0 : 4.0), 1.0, 1.0);
  const FrontPressure pressure = profile.finish();
  EXPECT_DOUBLE_EQ(pressure.impact_pressure, 4.0);
  EXPECT_EQ(pressure.pressure.front(), 0.0);
  EXPECT_DOUBLE_EQ(pressure.compaction, 17.0 / (arm.box_area * H * rho0)) << "one of 1 kg in 0.1 m from 2 to 3.75 m";
}

TEST(ImpactGeometryOfShapes, MeasuresOverTheWidthThatTheFlowMeets) {
  const auto turned = before(BoxShape{.rotation = 0.25 * std::numbers::pi});
  EXPECT_NEAR(turned.obstacle_width, w * std::numbers::sqrt2, 1e-14);
  EXPECT_NEAR(turned.strip_half_width, 3.0 / 7.0 * w * std::numbers::sqrt2, 1e-14);
}

TEST(ImpactGeometryOfShapes, AreaOfTheBoxIsThatOfItsPoints) {
  std::mt19937_64 random{11};
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const ImpactGeometry geometry = before(typical.shape);
    constexpr int n = 200000;
    const double long_side = 4.0, across = 2.0 * geometry.strip_half_width;
    int inside = 0;
    for (int i = 0; i < n; ++i) {
      const Vec3 x(-1.5 + long_side * unit(random), across * (unit(random) - 0.5), 0.1);
      inside += geometry.in_profile_box(x) && x[0] < geometry.front(x[1]);
    }
    const double share = static_cast<double>(inside) / n;
    EXPECT_NEAR(share * long_side * across, geometry.box_area, 4.0 * std::sqrt(share * (1.0 - share) / n) * long_side * across);
  }
}

TEST(ImpactGeometryOfShapes, TakesTheStressNormalToTheSurface) {
  const double stress[6] = {-5.0, -3.0, -9.0, 1.5, 7.0, 8.0};
  EXPECT_EQ(before(BoxShape{}).normal_component({-0.1, 0.3, 1.0}, stress), -5.0);
  const auto wedge = before(WedgeShape{.depth = 0.5 * w});  // flanks at 45 degrees: n = (-1, +-1)/sqrt 2
  EXPECT_NEAR(wedge.normal_component({0.1, 0.3, 1.0}, stress), 0.5 * (-5.0 - 3.0) - 1.5, 1e-14);
  EXPECT_NEAR(wedge.normal_component({0.1, -0.3, 1.0}, stress), 0.5 * (-5.0 - 3.0) + 1.5, 1e-14);
  const double pressure[6] = {-4.0, -4.0, -4.0, 0.0, 0.0, 0.0};
  for (const auto& typical : testing::typical_shapes()) {
    EXPECT_NEAR(before(typical.shape).normal_component({0.05, 0.4, 1.0}, pressure), -4.0, 1e-14)
        << typical.name << ": a pressure has no direction";
  }
}

TEST(ImpactMeasurementsOfShapes, HydrostaticSnowBeforeAnyFrontMeasuresTheSame) {
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const ImpactGeometry geometry = before(typical.shape);
    PressureProfile profile(geometry);
    Runup runup(geometry);
    constexpr double s = 0.0625;
    for (double x = -4.0 + 0.5 * s; x < 2.5; x += s) {
      for (double y = -1.5 + 0.5 * s; y < 1.5; y += s) {
        if (std::abs(y) > 0.5 * geometry.obstacle_width || x > geometry.front(y)) continue;
        for (double z = 0.5 * s; z < H; z += s) {
          profile.add({x, y, z}, -rho0 * 9.81 * (H - z), 1.0, rho0 * s * s * s);
          runup.add({x, y, z}, rho0 * s * s * s);
        }
      }
    }
    const FrontPressure frame = profile.finish();
    EXPECT_NEAR(frame.impact_pressure, 0.5 * rho0 * 9.81 * H, 1e-8);
    EXPECT_NEAR(runup.finish().highest, H - 0.5 * s, 1e-12);
    // the lattice's columns against the area: half a spacing along the outline of 2 strip + 2 box
    EXPECT_NEAR(frame.compaction, 1.0, 0.5 * s * (2.0 / geometry.box_upstream + 1.0 / geometry.strip_half_width));
    EXPECT_NEAR(frame.pressure[0], rho0 * 9.81 * (H - 0.0625), 1e-8);
  }
}

TEST(ImpactMeasurementsOfShapes, BeforeALowMastThePressureIsThatUpToItsTop) {
  PressureProfile profile(before(BoxShape{}, 1.0));
  for (double z = 0.05; z < H; z += 0.1) profile.add({-0.1, 0.0, z}, z < 1.0 ? -2e3 : -1e3, 1.0, 1.0);
  EXPECT_DOUBLE_EQ(profile.finish().impact_pressure, 2e3);
}

TEST(ImpactMeasurementsOfShapes, SnowBehindTheObstacleIsNotMeasured) {
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const ImpactGeometry geometry = before(typical.shape);
    PressureProfile profile(geometry);
    Runup runup(geometry);
    profile.add({typical.outline().bounds().max().x() + 0.05, 0.1, 1.0}, -1e4, 1.0, 5.0);
    runup.add({typical.outline().bounds().max().x() + 0.05, 0.1, 1.0}, 1.0);
    EXPECT_EQ(runup.finish().highest, 0.0);
    EXPECT_EQ(profile.finish().impact_pressure, 0.0);
  }
}

}  // namespace
}  // namespace mpm
