#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/grid_update.hpp"
#include "support/solver_states.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

using testing::box_body;

constexpr double dx = 0.25;

/// 2 m high, 1.75 m wide and deep where the shape does not say otherwise.
ObstacleSpec obstacle(const AnyShape& shape) { return {.shape = shape, .height = 2.0}; }

Boundary boundary_of(const ObstacleSpec& spec, const Vec3& offset = Vec3::Zero()) {
  Case c = testing::empty_case();
  c.obstacle = spec;
  c.numerics.contact = ContactRule::nodal;
  c.numerics.grid_offset = offset / dx;
  return make_scene(c).boundaries.back();
}

bool covers(const Boundary& b, const Vec3& node) {
  return std::visit([&](const auto& shape) { return shape.covers(node, 0.0); }, b);
}
bool reaches(const Boundary& b, const Vec3& low, const Vec3& high) {
  return std::visit(
      [&](const auto& shape) {
        if constexpr (HasConstrain<std::decay_t<decltype(shape)>>) return shape.reaches(low, high, 0.0);
        return false;
      },
      b);
}
Vec3 constrain(const Boundary& b, const Vec3& node, const Vec3& v) {
  return std::visit(
      [&](const auto& shape) -> Vec3 {
        if constexpr (HasConstrain<std::decay_t<decltype(shape)>>) {
          return shape.constrain(node, v, 0.0);
        } else {
          throw std::logic_error("acts on several nodes together");
        }
      },
      b);
}

TEST(VerticalSolids, AreBuiltFromTheCase) {
  const auto skin = [](const AnyShape& shape) { return std::get<NodalSolid>(boundary_of(obstacle(shape))).skin; };
  EXPECT_EQ(skin(BoxShape{}), 0.0) << "as the paper's";
  EXPECT_EQ(skin(BoxShape{.rotation = 0.1}), 0.5 * dx);
  EXPECT_EQ(skin(BoxShape{.width = 1.0, .depth = 4.0, .rotation = 0.5 * std::numbers::pi}), 0.0) << "along the axes again";
  EXPECT_EQ(skin(WedgeShape{}), 0.5 * dx);
  EXPECT_EQ(skin(CylinderShape{}), 0.5 * dx);
}

TEST(VerticalSolids, HoldTheNodesUpToHalfACellOutside) {
  const auto round = boundary_of(obstacle(CylinderShape{}));  // centre (0.875, 0), radius 0.875
  EXPECT_TRUE(covers(round, {0.0, 0.0, 0.0}));
  EXPECT_TRUE(covers(round, {-0.124, 0.0, -5.0}));  // no bottom
  EXPECT_FALSE(covers(round, {-0.126, 0.0, 0.0}));
  EXPECT_TRUE(covers(round, {0.875, 0.0, 2.0}));
  EXPECT_FALSE(covers(round, {0.875, 0.0, 2.001}));  // no skin on the top
  const auto wedge = boundary_of(obstacle(WedgeShape{}));
  EXPECT_TRUE(covers(wedge, {-0.124, 0.0, 0.0}));
  EXPECT_FALSE(covers(wedge, {-0.126, 0.0, 0.0})) << "the skins of two sides meet far before a sharp edge";
  EXPECT_TRUE(covers(wedge, {1.874, 0.87, 0.0}));
  EXPECT_FALSE(covers(wedge, {1.86, 0.97, 0.0})) << "beside a corner the distance is that from the corner";
  EXPECT_FALSE(covers(wedge, {1.876, 0.0, 0.0}));
}

TEST(VerticalSolids, FlushWithTheGridHoldTheNodesOfTheBox) {
  const auto box = boundary_of(obstacle(BoxShape{}));
  auto quarter = obstacle(BoxShape{.rotation = 0.5 * std::numbers::pi + 1e-8});  // the same square with a skin
  const auto prism = boundary_of(quarter);
  ASSERT_GT(std::get<NodalSolid>(prism).skin, 0.0);
  int held = 0;
  for (int i = -3; i < 12; ++i) {
    for (int j = -6; j <= 6; ++j) {
      for (int k = 0; k < 12; ++k) {
        // sides at y = +-0.875 lie half-way between nodes: shifted by half a cell they are flush
        const Vec3 node(i * dx, (j + 0.5) * dx, k * dx);
        EXPECT_EQ(covers(box, node), covers(prism, node)) << node.transpose();
        held += covers(box, node);
      }
    }
  }
  EXPECT_EQ(held, 8 * 8 * 9);
}

TEST(VerticalSolids, StandForTheirOwnAreaAndHalfACellAroundIt) {
  struct Large {
    AnyShape shape;
    double area, perimeter;
  };
  for (const Large& large : {Large{CylinderShape{.width = 12.0}, 36.0 * std::numbers::pi, 12.0 * std::numbers::pi},
                             Large{WedgeShape{.width = 12.0, .depth = 12.0}, 72.0, 12.0 * (1.0 + std::sqrt(5.0))},
                             Large{BoxShape{.width = 12.0, .depth = 12.0, .rotation = 0.4}, 144.0, 48.0}}) {
    const auto solid = boundary_of(obstacle(large.shape));
    constexpr int placings = 25;  // on the grid: their mean knows nothing of where rows of nodes happen to lie
    double nodes = 0.0;
    for (int k = 0; k < placings; ++k) {
      const Vec3 shift(dx * k / placings, dx * (7 * k % placings) / placings, 0.0);
      for (int i = -40; i < 120; ++i) {
        for (int j = -60; j <= 60; ++j) nodes += covers(solid, Vec3(i * dx, j * dx, 0.0) - shift);
      }
    }
    const double area = nodes * dx * dx / placings;
    // round corners: pi (dx/2)^2 in all; the rest is what 25 placings leave of the scatter of some cells
    EXPECT_NEAR(area, large.area + 0.5 * dx * large.perimeter, 3.0 * dx * dx) << large.shape.index();
  }
}

TEST(VerticalSolids, StopWhatMovesInAndLetGoWhatMovesOut) {
  const auto round = boundary_of(obstacle(CylinderShape{}));
  std::mt19937_64 random{7};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int n = 0; n < 500; ++n) {
    const double angle = std::numbers::pi * unit(random), r = 0.875 * (0.7 + 0.35 * unit(random));
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0), node = Vec3(0.875, 0.0, 0.5) + r * out;
    const Vec3 v(unit(random), unit(random), unit(random));
    const Vec3 after = constrain(round, node, v);
    if (v.dot(out) >= 1e-9) {
      EXPECT_EQ(after, v);
    } else if (v.dot(out) < -1e-9) {
      EXPECT_NEAR(after.dot(out), 0.0, 1e-14);
      const Vec3 t0 = v - v.dot(out) * out, t1 = after - after.dot(out) * out;
      EXPECT_NEAR((t0 - t1).norm(), std::min(0.15 * -v.dot(out), t0.norm()), 1e-14);  // Coulomb
    }
  }
}

TEST(VerticalSolids, WedgeTurnsTheFlowAlongItsFlanksAndStopsItAtTheEdge) {
  auto spec = obstacle(WedgeShape{.width = 2.0 * 1.75 * std::tan(std::numbers::pi / 6.0)});  // half its angle is 30 degrees
  spec.friction = 0.0;
  const auto wedge = boundary_of(spec);
  const Vec3 v(10.0, 0.0, 0.0), along(std::cos(std::numbers::pi / 6.0), std::sin(std::numbers::pi / 6.0), 0.0);
  EXPECT_NEAR((constrain(wedge, {0.9, 0.5, 0.5}, v) - v.dot(along) * along).norm(), 0.0, 1e-13);
  EXPECT_NEAR((constrain(wedge, {0.9, -0.5, 0.5}, v) - v.dot(along) * Vec3(along.x(), -along.y(), 0.0)).norm(), 0.0, 1e-13);
  EXPECT_NEAR(constrain(wedge, {0.0, 0.0, 0.5}, v).norm(), 0.0, 1e-13) << "both flanks are as near: their mean points upstream";
  EXPECT_NEAR((constrain(wedge, {0.5, 0.0, 0.5}, Vec3(10.0, 0.0, -3.0)) - Vec3(0.0, 0.0, -3.0)).norm(), 0.0, 1e-13);
}

TEST(VerticalSolids, TopCarriesWhatIsNearerToItThanToAnySide) {
  for (const auto& spec : {obstacle(CylinderShape{}), obstacle(WedgeShape{}), obstacle(BoxShape{.rotation = 0.2})}) {
    const auto solid = boundary_of(spec);
    const Vec3 falling(0.0, 0.0, -4.0);
    EXPECT_EQ(constrain(solid, {1.1, 0.1, 2.0}, falling), Vec3::Zero());
    EXPECT_EQ(constrain(solid, {1.1, 0.1, 1.9}, falling), Vec3::Zero());
    EXPECT_EQ(constrain(solid, {1.1, 0.1, 0.2}, falling), falling) << "deep inside a side is nearer";
  }
}

TEST(VerticalSolids, MoveWithTheSceneAgainstTheGrid) {
  const Vec3 offset(0.3 * dx, -0.4 * dx, 0.2 * dx);
  std::mt19937_64 random{8};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const ObstacleSpec spec = obstacle(typical.shape);
    const auto here = boundary_of(spec), there = boundary_of(spec, offset);
    for (int n = 0; n < 2000; ++n) {
      const Vec3 x(1.0 + 1.5 * unit(random), 1.3 * unit(random), 2.0 * unit(random)), v(unit(random), unit(random), unit(random));
      EXPECT_EQ(covers(here, x), covers(there, x + offset));
      if (covers(here, x)) {
        EXPECT_LE((constrain(here, x, v) - constrain(there, x + offset, v)).norm(), 1e-12);
      }
    }
  }
}

TEST(VerticalSolids, WhatTheyCoverInABoxTheyReach) {
  std::mt19937_64 random{9};
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const auto solid = boundary_of(obstacle(typical.shape));
    int covered = 0;
    for (int n = 0; n < 3000; ++n) {
      const Vec3 low(4.0 * unit(random) - 1.5, 3.0 * unit(random) - 1.5, 3.0 * unit(random)), high = low + 0.75 * Vec3::Ones();
      const Vec3 x = low + (high - low).cwiseProduct(Vec3(unit(random), unit(random), unit(random)));
      if (!covers(solid, x)) continue;
      ++covered;
      EXPECT_TRUE(reaches(solid, low, high));
    }
    EXPECT_GT(covered, 100);
  }
}

TEST(VerticalSolids, ThatAreNotSymmetricAreRefusedBesideAMirrorPlane) {
  Case c = testing::empty_case();
  c.domain.mirror_y = true;
  c.obstacle = obstacle(BoxShape{.rotation = 0.3});
  EXPECT_THROW((void)make_scene(c), ConfigError);
  c.obstacle->as<BoxShape>().rotation = 0.25 * std::numbers::pi;
  EXPECT_NO_THROW((void)make_scene(c));
}

/// A block of snow thrown at an obstacle on a floor with friction.
Case thrown_at(const ObstacleSpec& spec) {
  Case c = testing::empty_case();
  c.material = testing::cam_clay_snow(0.8, 0.3);
  c.numerics.contact = ContactRule::nodal;
  c.numerics.transfer = Transfer::apic;
  c.bodies = {box_body({-0.75, -0.5, 0.0}, {-0.25, 0.5, 1.0}, {6.0, 0.0, 0.0})};
  c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.3)};
  c.obstacle = spec;
  c.obstacle->height = 0.5;
  return c;
}

TEST(VerticalSolids, MomentumClosesInEveryStepAndLayersAddUpToTheImpulse) {
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const Case c = thrown_at(obstacle(typical.shape));
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    Vec3 taken = Vec3::Zero(), by_layer = Vec3::Zero();
    double above_top = 0.0;
    Totals before = totals(state, scene);
    for (int i = 0; i < 200; ++i) {
      const StepReport r = step(state, scene, 1e-3);
      const Totals after = totals(state, scene);
      Vec3 change = r.gravity_impulse;
      for (const Impulse& impulse : r.impulses) change -= impulse.linear;
      // sums of 256 particles' momenta of some kg m/s
      ASSERT_LE((after.momentum - before.momentum - change).norm(), 1e-13 * (1.0 + before.momentum_scale)) << i;
      before = after;
      Vec3 layers = Vec3::Zero();
      for (std::size_t k = 0; k < r.layers.front().layer.size(); ++k) {
        const Vec3& part = r.layers.front().layer[k];
        layers += part;
        const double z = dx * (r.layers.front().first + static_cast<double>(k));
        if (z > 0.5 + 1e-9) above_top += part.norm();
      }
      ASSERT_LE((layers - r.impulses[*scene.obstacle].linear).norm(), 1e-13 * (1.0 + before.momentum_scale));
      taken += r.impulses[*scene.obstacle].linear;
      by_layer += layers;
    }
    EXPECT_GT(taken.x(), 50.0) << "of 900 N s that flew at it";
    EXPECT_EQ(above_top, 0.0);
  }
}

TEST(VerticalSolids, LowOnesCarryWhatRestsOnTheirTop) {
  for (const auto& spec : {obstacle(BoxShape{}), obstacle(CylinderShape{}), obstacle(BoxShape{.rotation = 0.3})}) {
    Case c = testing::empty_case();
    c.bodies = {box_body({0.625, -0.25, 0.5}, {1.125, 0.25, 1.0})};
    c.obstacle = spec;
    c.obstacle->height = 0.5;
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    advance(state, scene, 1.0);
    double impulse = 0.0, middle = 0.0;
    advance(state, scene, 2.0, [&](const StepReport& r) {
      impulse -= r.impulses[*scene.obstacle].linear.z();
      for (std::size_t k = 0; k < r.layers.front().layer.size(); ++k) {
        middle -= r.layers.front().layer[k].z() * dx * (r.layers.front().first + static_cast<double>(k));
      }
    });
    const double weight = 300.0 * 9.81 * 0.125;
    EXPECT_NEAR(impulse, weight, 0.005 * weight);  // as the column on the floor in the test of the momentum's balance
    EXPECT_NEAR(middle / impulse, 0.5, 0.5 * dx) << "by the layers at the top";
  }
}

TEST(VerticalSolids, HalfOfASymmetricDomainGivesTheForceOnTheWhole) {
  for (const auto& typical : testing::symmetric_shapes()) {
    SCOPED_TRACE(typical.name);
    Case whole = thrown_at(obstacle(typical.shape)), half = whole;
    half.domain.mirror_y = true;
    Vec3 force[2] = {Vec3::Zero(), Vec3::Zero()};
    for (const bool mirrored : {false, true}) {
      const Case& c = mirrored ? half : whole;
      const CaseScene scene = make_scene(c);
      State state = make_state(c, scene);
      for (int i = 0; i < 150; ++i) {
        force[mirrored] += whole_force(step(state, scene, 1e-3).impulses[*scene.obstacle].linear, {false, mirrored});
      }
    }
    // round-off that the flow spreads, as in the tests of the mirror planes
    EXPECT_LE((force[1] - force[0]).norm(), 1e-9 * force[0].norm());
  }
}

TEST(VerticalSolids, GiveTheSameBitsOnAnyNumberOfThreads) {
  for (const auto& typical : testing::typical_shapes()) {
    SCOPED_TRACE(typical.name);
    const Case c = thrown_at(obstacle(typical.shape));
    std::vector<std::vector<Particle>> last;
    std::vector<std::vector<Vec3>> layers;
    for (const int threads : {1, 3}) {
      omp_set_num_threads(threads);
      const CaseScene scene = make_scene(c);
      State state = make_state(c, scene);
      StepReport report;
      for (int i = 0; i < 100; ++i) report = step(state, scene, 1e-3);
      last.push_back(testing::stored_particles(state.grid));
      layers.push_back(report.layers.front().layer);
    }
    omp_set_num_threads(1);
    EXPECT_TRUE(testing::same_bytes(last[0], last[1]));
    EXPECT_EQ(layers[0], layers[1]);
    EXPECT_FALSE(layers[0].empty());
  }
}

TEST(Walls, HoldASpeedThatVariesWithHeightAndTime) {
  const Wall belt{
      .point = Vec3(-1.0, 0.0, 0.1), .normal = Vec3::UnitX(), .contact = Contact::slip, .speed = [](double height, double time) {
        return 3.0 * height + time;
      }};
  EXPECT_TRUE(belt.covers({-1.0, 0.0, 0.0}, 0.0));
  EXPECT_FALSE(belt.covers({-0.9, 0.0, 0.0}, 7.0)) << "it is at rest";
  EXPECT_LE((belt.constrain({-1.0, 0.0, 1.1}, {9.0, 1.0, 2.0}, 0.5) - Vec3(3.5, 1.0, 2.0)).norm(), 1e-15);
}

}  // namespace
}  // namespace mpm
