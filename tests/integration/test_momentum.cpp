/// The balance that StepReport promises: P(t+dt) - P(t) = entered + gravity - sum of impulses - left, in every single step.

#include <gtest/gtest.h>

#include "libmpm/core/diagnostics.hpp"
#include "support/ground.hpp"
#include "support/solver_states.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

using testing::box_body;
using testing::wall;

/// Steps and checks each; returns the impulses' sum over all steps.
std::vector<Vec3> expect_balance(const Case& c, int steps) {
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  std::vector<Vec3> impulses(scene.boundaries.size(), Vec3::Zero());
  Totals before = totals(state, scene);
  for (int n = 0; n < steps; ++n) {
    const StepReport report = step(state, scene, stable_time_step(state, scene));
    const Totals after = totals(state, scene);
    Vec3 change = after.momentum - before.momentum, expected = report.entered.momentum + report.gravity_impulse - report.left.momentum;
    // Round-off is that of momentum sums: some ulp of sum m |v|, bounded through the energy (Cauchy-Schwarz), and of the stress's pushes,
    // which cancel in the sum: less than m 1 m/s a step.
    const double mass = before.mass + report.entered.mass,
                 size = std::sqrt(2.0 * mass * (before.kinetic_energy + after.kinetic_energy)) + mass;
    for (std::size_t b = 0; b < report.impulses.size(); ++b) {
      expected -= report.impulses[b].linear;
      impulses[b] += report.impulses[b].linear;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if ((axis == 0 && scene.mirror.x) || (axis == 1 && scene.mirror.y)) continue;  // across a mirror the other half pushes
      EXPECT_NEAR(change[axis], expected[axis], 1e-13 * size) << "axis " << axis << ", step " << n;
    }
    EXPECT_NEAR(after.mass, before.mass + report.entered.mass - report.left.mass, 1e-13 * mass) << n;
    if (::testing::Test::HasFailure()) break;
    before = after;
  }
  return impulses;
}

struct Scheme {
  const char* name;
  Transfer transfer;
  ContactRule contact;
};
class Momentum : public ::testing::TestWithParam<Scheme> {
 protected:
  static void use_scheme(Case& c) {
    c.numerics.transfer = GetParam().transfer;
    c.numerics.contact = GetParam().contact;
  }
  static Case scene_by_hand() {
    Case c = testing::empty_case();
    use_scheme(c);
    return c;
  }
};
void PrintTo(const Scheme& s, std::ostream* out) { *out << s.name; }
INSTANTIATE_TEST_SUITE_P(All, Momentum,
                         ::testing::Values(Scheme{"Apic", Transfer::apic, ContactRule::nodal},
                                           Scheme{"Flip", Transfer::flip, ContactRule::nodal},
                                           Scheme{"Aflip", Transfer::aflip, ContactRule::nodal},
                                           Scheme{"ApicAtSurfaces", Transfer::apic, ContactRule::surface},
                                           Scheme{"AflipAtSurfaces", Transfer::aflip, ContactRule::surface}),
                         [](const auto& scheme) { return scheme.param.name; });

TEST_P(Momentum, ClosesWhereBodiesHitWallsOfEveryKindAndLeave) {
  Case c = scene_by_hand();
  c.material = testing::cam_clay_snow(0.8, 0.3);
  c.numerics.slope = 0.2;
  c.bodies = {box_body({-0.9, -0.9, 0.1}, {-0.3, -0.3, 0.8}, {-6.0, 1.0, -3.0}),
              box_body({0.2, 0.2, 0.1}, {0.8, 0.9, 0.6}, {5.0, 6.0, -2.0}), box_body({-0.4, 0.0, 1.0}, {0.4, 0.5, 1.5}, {1.0, 0.0, 12.0})};
  c.bodies[1].shape = BodySpec::Shape::sphere;
  c.walls = {wall(Vec3::Zero(), {0.1, 0.0, 1.0}, Contact::separable, 0.4), wall({-1.0, 0.0, 0.0}, Vec3::UnitX(), Contact::no_slip),
             wall({1.0, 0.0, 0.0}, {-1.0, -0.2, 0.0}, Contact::slip, 0.2), wall({0.0, 1.1, 0.0}, -Vec3::UnitY(), Contact::separable)};
  c.walls[1].velocity = Vec3(0.5, 1.0, 0.0);
  c.domain.max = Vec3(20.0, 20.0, 1.6);  // the third body leaves
  ObstacleSpec box;
  box.shape = BoxShape{.width = 0.5, .depth = 0.4};
  box.height = 0.5;
  c.obstacle = box;
  const auto impulses = expect_balance(c, 200);
  for (std::size_t b = 0; b < impulses.size(); ++b) EXPECT_GT(impulses[b].norm(), 0.1) << "boundary " << b << " took no part";  // N s
}

TEST_P(Momentum, ClosesOnTheConveyorInWhichSnowEntersHitsTheMastAndLeaves) {
  for (const bool mirror : {true, false}) {
    Case c = testing::small_avalanche();
    use_scheme(c);
    c.conveyor->mirror_y = mirror;
    const auto impulses = expect_balance(c, 450);  // 0.7 s: past the mast and out of the window
    for (std::size_t b = 0; b < impulses.size(); ++b) EXPECT_GT(impulses[b].norm(), 1.0) << "boundary " << b << " took no part";
  }
}

TEST_P(Momentum, ClosesAtObstaclesOfEveryShapeAndOverTheirTop) {
  for (const auto& typical : testing::typical_shapes(0.8)) {
    for (const bool mirror : {true, false}) {
      Case c = testing::small_avalanche(6.0);
      use_scheme(c);
      c.conveyor->mirror_y = mirror;
      c.conveyor->upstream_length = 1.0;
      c.conveyor->width = 2.0;
      c.obstacle->shape = typical.shape;
      c.obstacle->height = 0.6;  // of the flow's 1 m
      c.obstacle->friction = 0.3;
      if (mirror && !typical.outline().symmetric()) continue;
      const auto impulses = expect_balance(c, 200);           // 0.3 s: past the obstacle
      EXPECT_GT(impulses.back().x(), 100.0) << typical.name;  // N s
    }
  }
}

TEST_P(Momentum, ClosesAtAMastWithAnArm) {
  for (const double friction : {0.0, 0.3}) {
    Case c = testing::small_avalanche(6.0);
    use_scheme(c);
    c.conveyor->upstream_length = 1.0;
    c.obstacle->friction = friction;
    const auto bare = expect_balance(c, 200);
    c.arm = ArmSpec{.length = 1.5, .depth = 0.5, .base = 0.25, .height = 1.0};  // in the flow of 1 m
    const auto impulses = expect_balance(c, 200);
    ASSERT_EQ(impulses.size(), bare.size() + 1);
    EXPECT_GT(impulses.back().x(), 100.0);  // N s
    c.arm = ArmSpec{.length = 1.5, .depth = 0.3, .base = 40.0, .height = 41.0};
    const auto above = expect_balance(c, 200);
    EXPECT_EQ(above.back(), Vec3::Zero());
    for (std::size_t b = 0; b < bare.size(); ++b) EXPECT_EQ(above[b], bare[b]) << "an arm out of reach changes nothing";
  }
}

TEST_P(Momentum, ClosesOnUnevenGroundRoundAMast) {
  for (const double friction : {0.0, 0.3}) {
    Case c = testing::small_avalanche(6.0);
    use_scheme(c);
    c.conveyor->mirror_y = false;
    c.conveyor->sidewall_contact = Contact::slip;
    c.conveyor->upstream_length = 1.0;
    c.obstacle->friction = 0.3;
    c.terrain = testing::ground_spec([](double x, double y) { return 0.2 * std::sin(2.0 * x) * std::cos(1.5 * y); }, 6.0, 0.25);
    c.terrain->friction = friction;
    const auto impulses = expect_balance(c, 200);
    EXPECT_GT(impulses.front().norm(), 100.0) << "the ground";  // N s
    EXPECT_GT(impulses.back().x(), 100.0) << "the mast";
  }
}

TEST_P(Momentum, ClosesAlongAMirrorPlane) {
  Case c = scene_by_hand();
  c.domain.mirror_x = c.domain.mirror_y = true;
  c.bodies = {box_body({-0.5, -0.5, 0.1}, {0.5, 0.5, 1.1}, {0.0, 0.0, -5.0})};
  c.walls = {wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.3)};
  expect_balance(c, 200);
}

TEST_P(Momentum, OfARestingColumnGivesTheFloorItsWeight) {
  for (const MaterialParameters& material : {testing::elastic_snow(), testing::cam_clay_snow(0.8, 0.3)}) {
    Case c = scene_by_hand();
    c.material = material;
    c.bodies = {box_body(Vec3::Zero(), {0.5, 0.5, 1.0})};
    c.walls = {wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable)};
    for (const int axis : {0, 1}) {
      c.walls.push_back(wall(Vec3::Zero(), Vec3::Unit(axis), Contact::slip));
      c.walls.push_back(wall(0.5 * Vec3::Unit(axis), -Vec3::Unit(axis), Contact::slip));
    }
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    // Dropped without stress it swings about its equilibrium with amplitude m g H / c_P of the momentum, 0.17 m/s. Over a second that could
    // change the floor's part by 0.17 / 9.81 = 1.7 %. Walls that act on nodes damp it: little is left after the first second. At surfaces
    // they do not, and it loses a fifth (APIC) or a tenth (AFLIP) a second.
    double impulse = 0.0;  // of the column on the floor, downwards
    advance(state, scene, 1.0);
    advance(state, scene, 2.0, [&](const StepReport& report) { impulse -= report.impulses[0].linear.z(); });
    const double weight = 9.81 * 300.0 * 0.25;
    EXPECT_NEAR(impulse, weight, (GetParam().contact == ContactRule::nodal ? 0.005 : 0.017) * weight);
  }
}

}  // namespace
}  // namespace mpm
