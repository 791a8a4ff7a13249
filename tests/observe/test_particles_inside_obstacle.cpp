#include "libmpm/observe/particles_inside_obstacle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/run.hpp"
#include "libmpm/io/snapshot.hpp"
#include "libmpm/observe/observer_list.hpp"
#include "support/solver_states.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

constexpr double dx = 0.25, density = 300.0;
const ObstacleSpec box{.shape = BoxShape{}};
const ParticlesInsideObstacle::Setting setting{.cell_size = dx, .density = density, .snow_depth = 1.75};

/// A frame with particles at these places, each of reference volume 0.002 m^3, compacted to half of it.
Snapshot frame_of(const std::vector<Vec3>& places) {
  Snapshot frame;
  frame.info.reference_density = density;
  for (const Vec3& x : places) {
    ParticleTable& t = frame.particles;
    t.id.push_back(t.id.size());
    t.position.insert(t.position.end(), x.data(), x.data() + 3);
    t.stress.resize(t.stress.size() + 6, 0.0);
    t.internal.push_back(0.0);
    t.volume_ratio.push_back(0.5);
    t.volume.push_back(0.002);
  }
  return frame;
}

/// particles_inside_obstacle, volume_inside_obstacle_m3, depth_inside_obstacle_m
std::array<double, 3> measured(ParticlesInsideObstacle& observer, const std::vector<Vec3>& places) {
  const Snapshot frame = frame_of(places);
  observer.visit(ParticleBatch(frame));
  std::array<double, 3> row{};
  observer.sample({}, row);
  return row;
}
std::array<double, 3> measured(const ObstacleSpec& spec, const std::vector<Vec3>& places) {
  ParticlesInsideObstacle observer({spec.solid()}, setting);
  return measured(observer, places);
}

/// Distance behind the outline of a shape, m, found from its corners alone (a circle has 256); negative outside.
double depth_in_plan(const Outline& outline, const Vec2& x) {
  bool inside = false;
  double nearest = 1e9;
  for (const auto& [a, b, normal, offset] : outline.sides()) {
    const double part = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (a + part * (b - a) - x).norm());
    if ((a.y() > x.y()) != (b.y() > x.y()) && x.x() < a.x() + (x.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside ? nearest : -nearest;
}

TEST(ParticlesInsideObstacle, AreCountedFromATenthOfACellBehindTheNearestSurfaceOfAnyShape) {
  std::mt19937_64 random{3};
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const auto& typical : testing::typical_shapes()) {
    for (const auto& [height, base] : {std::pair<std::optional<double>, double>{{}, 0.0}, {1.2, 0.0}, {1.7, 0.3}}) {
      SCOPED_TRACE(typical.name + (height ? ", up to " + std::to_string(*height) : ""));
      std::vector<Vec3> places;
      double deepest = 0.0;
      int inside = 0, slightly = 0;
      for (int i = 0; i < 4000; ++i) {
        const Vec3 x(-0.5 + 3.5 * unit(random), -1.5 + 3.0 * unit(random), 2.0 * unit(random));
        const double below = std::min(height.value_or(1e9) - x.z(), base > 0.0 ? x.z() - base : 1e9);
        const double depth = std::min(depth_in_plan(outline_of(typical.shape), x.head<2>()), below);
        if (std::abs(depth - 0.1 * dx) < 1e-4) continue;  // the polygon of a cylinder is 7e-5 m inside it
        places.push_back(x);
        deepest = std::max(deepest, depth);
        inside += depth > 0.1 * dx;
        slightly += depth > 0.0 && depth < 0.1 * dx;
      }
      ASSERT_GT(inside, 100);
      ASSERT_GT(slightly, 10);
      const auto [count, volume, depth] = measured({.shape = typical.shape, .height = height, .base = base}, places);
      EXPECT_EQ(count, inside);
      EXPECT_NEAR(volume, 0.001 * inside, 1e-12) << "the present volume, half of that at the start";
      EXPECT_NEAR(depth, deepest, 1e-4);
    }
  }
}

TEST(ParticlesInsideObstacle, AreThoseOfTheRowAlone) {
  ParticlesInsideObstacle observer({box.solid()}, setting);
  EXPECT_EQ(measured(observer, {{0.875, 0.0, 1.0}})[0], 1.0);
  EXPECT_EQ(measured(observer, {{-0.1, 0.0, 1.0}}), (std::array{0.0, 0.0, 0.0}));
}

TEST(ParticlesInsideObstacle, AreThoseOfTheWholeFlowWithAMirrorPlane) {
  ParticlesInsideObstacle::Setting half = setting;
  half.mirror.y = true;
  ParticlesInsideObstacle observer({box.solid()}, half);
  const auto [count, volume, depth] = measured(observer, {{0.875, 0.1, 1.0}});
  EXPECT_EQ(count, 2.0);
  EXPECT_NEAR(volume, 0.002, 1e-15);
  EXPECT_NEAR(depth, 0.775, 1e-15);
}

TEST(ParticlesInsideObstacle, AskForTheBlocksThatMeetTheObstacleOnly) {
  const ParticlesInsideObstacle observer({ObstacleSpec{.shape = BoxShape{}, .height = 2.0}.solid()}, setting);
  EXPECT_TRUE(observer.visits({-1.0, 0.0, 0.0}, {0.1, 1.0, 1.0}));
  EXPECT_FALSE(observer.visits({-1.0, 0.0, 0.0}, {-0.1, 1.0, 1.0}));
  EXPECT_FALSE(observer.visits({0.0, 0.0, 2.5}, {1.0, 1.0, 3.5})) << "above its top";
  const ParticlesInsideObstacle above({ObstacleSpec{.shape = BoxShape{}, .base = 1.0}.solid()}, setting);
  EXPECT_FALSE(above.visits({0.0, 0.0, 0.0}, {1.0, 1.0, 0.9})) << "below its underside";
  const UprightSolid arm = ArmSpec{.length = 4.0, .depth = 0.5, .base = 1.0, .height = 1.5}.solid(box);
  ParticlesInsideObstacle both({ObstacleSpec{.shape = BoxShape{}, .height = 2.0}.solid(), arm}, setting);
  EXPECT_TRUE(both.visits({0.7, 1.5, 1.0}, {1.0, 2.5, 1.2})) << "beside the obstacle, on its arm";
  EXPECT_EQ(measured(both, {{0.875, 1.8, 1.2}, {0.875, 0.0, 1.2}, {0.875, 1.8, 0.5}})[0], 2.0);
}

/// A case with an obstacle and a block of fluid that reaches into it, which is not allowed in a file.
Case flooded(std::optional<double> height) {
  Case c;
  c.material = WeaklyCompressibleFluid::Parameters{};
  c.bodies = {{.min = {-1.0, -1.0, 0.0}, .max = {0.5, 1.0, 2.0}}};
  c.obstacle = ObstacleSpec{.shape = BoxShape{.width = 1.0, .depth = 1.0}, .height = height};
  c.domain = {.min = Vec3(-3.0, -3.0, 0.0), .max = Vec3(3.0, 3.0, 4.0)};
  c.numerics.cell_size = dx;
  return c;
}

TEST(ParticlesInsideObstacle, AreAShareOfTheObstacleWhoseExcessIsAFinding) {
  for (const std::optional<double> height : {std::optional<double>{}, std::optional(1.0)}) {
    const Case c = flooded(height);
    const CaseScene scene = make_scene(c);
    const State state = make_state(c, scene);
    ObserverList observers(make_observers(c, scene));
    observers.begin(state, scene);
    const LiveState live{state, scene, totals(state, scene)};
    (void)observers.sample({0.0, 0.0, &live});
    const RunProgress progress;
    const Results results = observers.results(observers.summary(&state, &progress));
    const double depth = std::min(height.value_or(2.0), 2.0), volume = results.number("volume_inside_obstacle_m3");
    EXPECT_NEAR(volume, 0.475 * 0.95 * (height ? depth - 0.025 : depth), 0.15 * volume) << "a lattice of particles 0.125 m apart";
    EXPECT_NEAR(results.number("share_inside_obstacle"), volume / depth, 1e-12) << "of 1 m x 1 m up to the bodies, or to the top";
    EXPECT_NEAR(results.number("depth_inside_obstacle_m"), 0.45, 0.1);
    ASSERT_EQ(result_warnings(results).size(), 1U);
    EXPECT_NE(result_warnings(results).front().find("of snow"), std::string::npos);
  }
  EXPECT_TRUE(result_warnings(expected_results(flooded({}))).empty()) << "nothing is known";
}

}  // namespace
}  // namespace mpm
