// Obstacles that begin above the ground.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/scene.hpp"
#include "support/solver_states.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

using testing::box_body;

constexpr double dx = 0.25;

/// A shape and where contact acts.
class Underside : public ::testing::TestWithParam<std::tuple<testing::TypicalShape, ContactRule>> {
 protected:
  /// An obstacle between two heights in an empty scene.
  static Case scene_of(double base, std::optional<double> top = {}) {
    Case c = testing::empty_case();
    c.material = testing::cam_clay_snow(0.8, 0.0);
    c.numerics.contact = std::get<1>(GetParam());
    c.obstacle = ObstacleSpec{.shape = std::get<0>(GetParam()).shape, .height = top, .base = base, .friction = 0.3};
    return c;
  }
};
INSTANTIATE_TEST_SUITE_P(Shapes, Underside,
                         ::testing::Combine(::testing::ValuesIn(testing::typical_shapes()),
                                            ::testing::Values(ContactRule::nodal, ContactRule::surface)),
                         [](const auto& test) {
                           return std::get<0>(test.param).name + (std::get<1>(test.param) == ContactRule::nodal ? "Nodal" : "Surface");
                         });

TEST_P(Underside, LetsAFlowPassBelow) {
  Case c = scene_of(1.0, 2.0);
  c.bodies = {box_body({-1.5, -0.5, 0.0}, {-0.25, 0.5, 0.5}, {6.0, 0.0, 0.0})};
  c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable)};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const double momentum = totals(state, scene).momentum.x();
  Vec3 taken = Vec3::Zero();
  advance(state, scene, 0.4, [&](const StepReport& r) { taken += r.impulses[*scene.obstacle].linear; });
  EXPECT_EQ(taken, Vec3::Zero());
  EXPECT_NEAR(totals(state, scene).momentum.x(), momentum, 1e-12 * momentum);
  double furthest = -10.0;
  state.grid.for_each_particle([&](const Particle& p) { furthest = std::max(furthest, p.position[0]); });
  EXPECT_GT(furthest, 1.5) << "under it";
}

/// The mirror image of snow that falls on a top.
TEST_P(Underside, StopsWhatRisesAgainstItAsATopStopsWhatFalls) {
  constexpr double plane = 2.0;  // of the mirror
  std::vector<Vec3> force[2];
  for (const bool mirrored : {false, true}) {
    Case c = mirrored ? scene_of(2.0 * plane - 1.05) : scene_of(0.0, 1.05);
    c.bodies = {mirrored ? box_body({0.4, -0.35, 2.0 * plane - 1.7}, {1.0, 0.35, 2.0 * plane - 1.2}, {1.0, 0.0, 5.0})
                         : box_body({0.4, -0.35, 1.2}, {1.0, 0.35, 1.7}, {1.0, 0.0, -5.0})};
    CaseScene scene = make_scene(c);
    if (mirrored) scene.gravity = -scene.gravity;
    State state = make_state(c, scene);
    Totals before = totals(state, scene);
    double deepest = 0.0;
    for (int i = 0; i < 150; ++i) {
      const StepReport r = step(state, scene, 1e-3);
      const Totals after = totals(state, scene);
      const Vec3 taken = r.impulses[*scene.obstacle].linear;
      // sums of some hundred particles' momenta of some kg m/s
      ASSERT_LE((after.momentum - before.momentum - r.gravity_impulse + taken).norm(), 1e-13 * (1.0 + before.momentum_scale)) << i;
      before = after;
      Vec3 layers = Vec3::Zero();
      for (const Vec3& layer : r.layers.front().layer) layers += layer;
      ASSERT_LE((layers - taken).norm(), 1e-13 * (1.0 + before.momentum_scale));
      force[mirrored].push_back(mirrored ? taken.cwiseProduct(Vec3(1.0, 1.0, -1.0)) : taken);
      if (c.numerics.contact == ContactRule::nodal) continue;  // holds nodes, not particles
      state.grid.for_each_particle([&](const Particle& p) {
        deepest = std::max(deepest, -geometry_of(scene.boundaries.back())->nearest(testing::position_of(p)).distance);
      });
    }
    EXPECT_LE(deepest, 0.1 * dx);
    const double rising = before.momentum.z() * (mirrored ? 1.0 : -1.0);
    EXPECT_LE(rising, 0.5 * 5.0 * before.mass) << "most of it was stopped";
  }
  double difference = 0.0, whole = 0.0;
  for (std::size_t i = 0; i < force[0].size(); ++i) {
    difference = std::max(difference, (force[1][i] - force[0][i]).norm());
    whole = std::max(whole, force[0][i].norm());
  }
  EXPECT_GT(whole, 1.0);
  EXPECT_LE(difference, 1e-8 * whole) << "round-off that the flow spreads";
}

/// A box that hangs in a tank of fluid at rest: the layers at its underside take the pressure there, those at its top that of the top.
TEST(UndersideOfACoveredObstacle, CarriesThePressureOfAFluidAtRest) {
  Case c = testing::empty_case();
  WeaklyCompressibleFluid::Parameters fluid;
  fluid.bulk_modulus = 270e3;  // 30 m/s: it settles by 0.5 %
  fluid.viscosity = 30.0;
  c.material = fluid;
  c.numerics.cell_size = 0.125;
  c.domain.mirror_y = true;
  constexpr double base = 0.375, top = 0.75, surface = 1.0, area = 0.25;
  c.obstacle = ObstacleSpec{.shape = BoxShape{.width = 0.5, .depth = 0.5}, .height = top, .base = base, .friction = 0.0};
  c.bodies = {box_body({-0.5, 0.0, 0.0}, {1.0, 0.75, base}), box_body({-0.5, 0.0, base}, {0.0, 0.75, top}),
              box_body({0.5, 0.0, base}, {1.0, 0.75, top}), box_body({0.0, 0.25, base}, {0.5, 0.75, top}),
              box_body({-0.5, 0.0, top}, {1.0, 0.75, surface})};
  for (const auto& [point, normal] : {std::pair<Vec3, Vec3>{Vec3::Zero(), Vec3::UnitZ()},
                                      {{-0.5, 0.0, 0.0}, Vec3::UnitX()},
                                      {{1.0, 0.0, 0.0}, -Vec3::UnitX()},
                                      {{0.0, 0.75, 0.0}, -Vec3::UnitY()}})
    c.walls.push_back(testing::wall(point, normal, Contact::slip));
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  advance(state, scene, 1.0);
  double below = 0.0, above = 0.0;
  advance(state, scene, 2.0, [&](const StepReport& r) {
    const LayerImpulses& layers = r.layers.front();
    for (std::size_t k = 0; k < layers.layer.size(); ++k) {
      const double z = c.numerics.cell_size * (layers.first + static_cast<double>(k));
      (z < 0.5 * (base + top) ? below : above) += 2.0 * layers.layer[k].z();
    }
  });
  const double weight = fluid.density * 9.81 * area, on_underside = weight * (surface - base), buoyancy = weight * (top - base);
  // the floor carries the pressure of the depth, so the tank's balance leaves Archimedes' force for the box, whatever its edges take
  EXPECT_NEAR(below + above, buoyancy, 0.02 * buoyancy);
  EXPECT_LT(above, 0.0);
  // with four cells across, the edges of a face carry too little: 0.93 of the exact force on an underside alone, 0.98 with eight
  EXPECT_NEAR(below, 0.93 * on_underside, 0.08 * on_underside);
}

}  // namespace
}  // namespace mpm
