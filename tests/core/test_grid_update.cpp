#include "libmpm/core/grid_update.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <random>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/transfer.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

/// A box with nodal contact. @param low, high  its corners, m
NodalSolid box_between(const Vec3& low, const Vec3& high, Contact contact = Contact::separable, double friction = 0.0,
                       const Vec3& reference = Vec3::Zero()) {
  const Outline plan({{low.x(), low.y()}, {high.x(), low.y()}, {high.x(), high.y()}, {low.x(), high.y()}});
  return {{plan, low.z(), high.z()}, 0.0, contact, friction, reference};
}

using testing::box_body;
using testing::position_of;
using testing::velocity_of;

constexpr double dx = 0.25;
constexpr double eps = 1e-14;  ///< some roundings of velocities of a few m/s

class Contacts : public ::testing::Test {
 protected:
  Vec3 random_vector(double size) {
    std::uniform_real_distribution<double> d(-size, size);
    return {d(random), d(random), d(random)};
  }
  /// f(v, n, u) for many velocities, normals and surface velocities.
  template <class F>
  void for_many(F&& f) {
    for (int i = 0; i < 3000; ++i) f(random_vector(5.0), random_vector(1.0).normalized(), random_vector(2.0));
  }
  std::mt19937_64 random{31};
};

TEST_F(Contacts, NoSlipTakesTheVelocityOfTheSurface) {
  for_many([](const Vec3& v, const Vec3& n, const Vec3& u) { EXPECT_EQ(contact_velocity(v, n, u, Contact::no_slip, 0.3), u); });
}

TEST_F(Contacts, SlipStaysOnTheSurfaceAndKeepsTheTangentialPart) {
  for_many([](const Vec3& v, const Vec3& n, const Vec3& u) {
    const Vec3 r = contact_velocity(v, n, u, Contact::slip, 0.0) - u, before = v - u;
    EXPECT_NEAR(r.dot(n), 0.0, eps);
    EXPECT_LE((r - (before - before.dot(n) * n)).norm(), eps);
  });
}

TEST_F(Contacts, SeparableLetsGoWhatMovesAwayAndHoldsWhatApproaches) {
  for_many([](const Vec3& v, const Vec3& n, const Vec3& u) {
    const Vec3 after = contact_velocity(v, n, u, Contact::separable, 0.4);
    if ((v - u).dot(n) >= 0.0) {
      EXPECT_EQ(after, v);  // to the bit: friction neither
    } else {
      EXPECT_NEAR((after - u).dot(n), 0.0, eps);
    }
  });
}

TEST_F(Contacts, FrictionStaysInTheCoulombConeAndNeverReverses) {
  for (const Contact contact : {Contact::slip, Contact::separable}) {
    for (const double mu : {0.0, 0.15, 0.7, 3.0}) {
      for_many([&](const Vec3& v, const Vec3& n, const Vec3& u) {
        const Vec3 before = v - u, after = contact_velocity(v, n, u, contact, mu) - u;
        const double normal_loss = std::max(0.0, -before.dot(n));  // only pressing material rubs
        const Vec3 t0 = before - before.dot(n) * n, t1 = after - after.dot(n) * n;
        const double tangential_loss = (t0 - t1).norm();
        EXPECT_LE(tangential_loss, mu * normal_loss + eps);
        EXPECT_GE(t0.dot(t1), -eps);
        EXPECT_LE(t0.cross(t1).norm(), 10.0 * eps);    // along the slip
        EXPECT_LE(after.norm(), before.norm() + eps);  // takes energy, relative to the surface
        if (t1.norm() > 10.0 * eps) {                  // sliding: the whole cone
          EXPECT_NEAR(tangential_loss, mu * normal_loss, eps);
        }
      });
    }
  }
}

TEST_F(Contacts, DoNotDependOnTheFrameOfTheObserver) {
  for (const Contact contact : {Contact::no_slip, Contact::slip, Contact::separable}) {
    for_many([&](const Vec3& v, const Vec3& n, const Vec3& u) {
      const Vec3 shift = random_vector(10.0);
      if (std::abs((v - u).dot(n)) < 1e-9) return;  // on the edge between pressing and leaving round-off decides
      EXPECT_LE((contact_velocity(v + shift, n, u + shift, contact, 0.3) - contact_velocity(v, n, u, contact, 0.3) - shift).norm(),
                10.0 * eps);
    });
  }
}

TEST_F(Contacts, WhatABoundaryCoversInABoxItReaches) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int n = 0; n < 3000; ++n) {
    Wall wall{random_vector(1.0), random_vector(1.0).normalized(), Contact::slip, 0.0, random_vector(1.0), n % 2 == 0};
    if (n % 5 == 0) wall.normal = Vec3::Unit(n % 3) * (n % 2 == 0 ? 1.0 : -1.0);
    const Vec3 corner_of_box = random_vector(1.0);
    const NodalSolid box = box_between(corner_of_box, corner_of_box + Vec3(unit(random), unit(random), unit(random)));
    const Vec3 low = random_vector(1.5), high = low + 0.75 * Vec3::Ones();
    const double time = unit(random);
    for (const Vec3& corner : {low, high, Vec3(low + (high - low).cwiseProduct(Vec3(unit(random), unit(random), unit(random))))}) {
      if (wall.covers(corner, time)) {
        EXPECT_TRUE(wall.reaches(low, high, time));
      }
      if (box.covers(corner, time)) {
        EXPECT_TRUE(box.reaches(low, high, time));
      }
    }
  }
}

TEST(Walls, CoverTheirPlaneAndWhatIsBehind) {
  const Wall floor{Vec3(0.0, 0.0, 0.3), Vec3::UnitZ()};
  EXPECT_TRUE(floor.covers({5.0, 5.0, 0.3}, 0.0));
  EXPECT_TRUE(floor.covers({5.0, 5.0, 0.1 + 0.2}, 0.0));  // 0.30000000000000004: on the plane but for a rounding
  EXPECT_TRUE(floor.covers({5.0, 5.0, -100.0}, 0.0));
  EXPECT_FALSE(floor.covers({5.0, 5.0, 0.301}, 0.0));
}

TEST(Walls, TravelWithTheirVelocityOrStandAsABelt) {
  const Wall piston{Vec3::Zero(), Vec3::UnitX(), Contact::separable, 0.0, Vec3(2.0, 7.0, 0.0), true};
  EXPECT_FALSE(piston.covers({1.0, 0.0, 0.0}, 0.49));
  EXPECT_TRUE(piston.covers({1.0, 0.0, 0.0}, 0.5));
  const Wall belt{Vec3::Zero(), Vec3::UnitX(), Contact::slip, 0.0, Vec3(2.0, 0.0, 0.0), false};
  EXPECT_FALSE(belt.covers({1.0, 0.0, 0.0}, 10.0));
  EXPECT_EQ(belt.constrain(Vec3::Zero(), {0.0, 1.0, 1.0}, 0.0), Vec3(2.0, 1.0, 1.0));
}

TEST(NodalSolids, StopWhatMovesIntoTheNearestFace) {
  const NodalSolid box = box_between({0.0, -1.0, -10.0}, {2.0, 1.0, 3.0}, Contact::slip);
  const Vec3 v(1.0, 2.0, 4.0);
  const auto stopped = [&](const Vec3& node) -> Vec3 { return v - box.constrain(node, v, 0.0); };
  EXPECT_EQ(stopped({0.1, 0.0, 0.0}), Vec3(1.0, 0.0, 0.0));   // upstream face
  EXPECT_EQ(stopped({1.9, 0.0, 0.0}), Vec3(1.0, 0.0, 0.0));   // downstream face
  EXPECT_EQ(stopped({1.0, -0.9, 0.0}), Vec3(0.0, 2.0, 0.0));  // sides
  EXPECT_EQ(stopped({1.0, 0.9, 0.0}), Vec3(0.0, 2.0, 0.0));
  EXPECT_EQ(stopped({1.0, 0.0, 2.9}), Vec3(0.0, 0.0, 4.0));   // top
  EXPECT_EQ(stopped({1.0, 0.0, -9.9}), Vec3(0.0, 0.0, 4.0));  // underside
  // edges: of the sides the one further upstream, then the top
  EXPECT_EQ(stopped({0.0, 1.0, 3.0}), Vec3(1.0, 0.0, 0.0));
  EXPECT_EQ(stopped({2.0, -1.0, 3.0}), Vec3(0.0, 2.0, 0.0));
  EXPECT_EQ(stopped({1.0, 1.0, 3.0}), Vec3(0.0, 2.0, 0.0));
}

TEST(NodalSolids, LetGoWhatMovesOutOfEachFace) {
  const NodalSolid box = box_between({0.0, -1.0, -10.0}, {2.0, 1.0, 3.0}, Contact::separable, 0.5);
  for (const auto& [node, out] : std::vector<std::pair<Vec3, Vec3>>{{{0.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}},
                                                                    {{2.0, 0.0, 0.0}, {1.0, 0.0, 0.0}},
                                                                    {{1.0, -1.0, 0.0}, {0.0, -1.0, 0.0}},
                                                                    {{1.0, 1.0, 0.0}, {0.0, 1.0, 0.0}},
                                                                    {{1.0, 0.0, 3.0}, {0.0, 0.0, 1.0}},
                                                                    {{1.0, 0.0, -10.0}, {0.0, 0.0, -1.0}}}) {
    const Vec3 along(0.3, 0.2, 0.1), leaving = out + along - along.dot(out) * out;
    EXPECT_EQ(box.constrain(node, leaving, 0.0), leaving);
    EXPECT_NEAR(box.constrain(node, -leaving, 0.0).dot(out), 0.0, eps);
  }
}

TEST(NodalSolids, CoverTheirFacesAndInside) {
  const NodalSolid box = box_between({0.0, -1.0, -10.0}, {2.0, 1.0, 3.0});
  EXPECT_TRUE(box.covers({0.0, -1.0, 3.0}, 0.0));
  EXPECT_TRUE(box.covers({1.0, 0.0, 0.0}, 0.0));
  EXPECT_FALSE(box.covers({-0.001, 0.0, 0.0}, 0.0));
  EXPECT_FALSE(box.covers({1.0, 0.0, 3.001}, 0.0));
  EXPECT_FALSE(box.covers({1.0, 0.0, -10.001}, 0.0));
}

/// Nodes of a few blocks with random masses and momenta.
class GridUpdate : public ::testing::Test {
 protected:
  GridUpdate() : grid(dx) {
    std::uniform_real_distribution<double> place(-1.2, 1.2);
    for (std::uint64_t i = 0; i < 300; ++i) {
      Particle p = testing::particle_at({place(random), place(random), place(random)}, i);
      testing::randomise(p, random);
      grid.insert(p);
    }
    grid.refresh();
    particle_to_grid(grid, {1e-3, 300.0, true});
  }
  struct NodeState {
    Vec3 position, momentum;
    double mass;
  };
  std::vector<NodeState> nodes(bool velocities) {
    std::vector<NodeState> all;
    for (const auto b : grid.own_blocks()) {
      const Index3& c = grid.block(b).coordinate;
      for (int n = 0; n < block_nodes; ++n) {
        const Node& v = grid.velocities(b).node[n];
        all.push_back({node_position(c, n, dx), (velocities ? v[3] : 1.0) * Vec3(v[0], v[1], v[2]), v[3]});
      }
    }
    return all;
  }
  std::mt19937_64 random{33};
  Grid grid;
};

TEST_F(GridUpdate, GivesEveryNodeItsVelocityAndGravity) {
  const auto before = nodes(false);
  const Vec3 g(1.0, 2.0, -9.81);
  const auto [mass, impulses, layers] = update_grid(grid, {.gravity = g}, 0.01, 0.0).total(one_rank());
  const auto after = nodes(true);
  double sum = 0.0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    sum += before[i].mass;
    EXPECT_EQ(after[i].mass, before[i].mass);
    if (before[i].mass > 0.0) {
      EXPECT_LE((after[i].momentum - before[i].momentum - 0.01 * before[i].mass * g).norm(), 1e-14 * (1.0 + before[i].momentum.norm()));
    }
  }
  EXPECT_NEAR(mass, sum, 1e-13 * sum);
  EXPECT_TRUE(impulses.empty());
  EXPECT_TRUE(layers.empty());
}

TEST_F(GridUpdate, BooksTheMomentumThatEachBoundaryTookLinearAndAngular) {
  const Boundary one[] = {Wall{Vec3(0.1, 0.2, -0.3), Vec3(0.6, 0.0, 0.8), Contact::separable, 0.4, Vec3(0.5, 1.0, 0.0)},
                          box_between({-0.5, -0.5, -2.0}, {0.5, 0.5, 2.0}, Contact::separable, 0.2, {0.1, 0.2, 0.3})};
  for (const Boundary& boundary : one) {
    particle_to_grid(grid, {1e-3, 300.0, true});
    const auto before = nodes(false);
    const auto impulses = update_grid(grid, {.boundaries = {&boundary, 1}}, 1e-3, 0.0).total(one_rank()).impulses;
    const auto after = nodes(true);
    const Vec3 about = std::visit([](const auto& b) { return b.reference_point(); }, boundary);
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    double scale = 0.0;
    for (std::size_t i = 0; i < after.size(); ++i) {
      const Vec3 taken = before[i].momentum - after[i].momentum;
      linear += taken;
      angular += (before[i].position - about).cross(taken);
      scale += before[i].momentum.norm();
    }
    ASSERT_EQ(impulses.size(), 1U);
    EXPECT_GT(linear.norm(), 1e-3 * scale);                          // it did something
    EXPECT_LE((impulses[0].linear - linear).norm(), 1e-14 * scale);  // the same terms in another order
    EXPECT_LE((impulses[0].angular - angular).norm(), 1e-13 * scale);
  }
}

TEST_F(GridUpdate, BooksASharedNodeOnePartAfterTheOther) {
  const Wall floor{Vec3::Zero(), Vec3::UnitZ(), Contact::slip};
  const NodalSolid mast = box_between({0.0, -0.5, -10.0}, {0.5, 0.5, 10.0}, Contact::slip);
  const Boundary both[] = {floor, mast};
  const auto before = nodes(false);
  const auto impulses = update_grid(grid, {.boundaries = both}, 1e-3, 0.0).total(one_rank()).impulses;
  const auto after = nodes(true);
  Vec3 by_floor = Vec3::Zero(), by_mast = Vec3::Zero();
  int shared = 0;
  double scale = 0.0;
  for (const NodeState& n : before) {
    if (n.mass <= 0.0) continue;
    scale += n.momentum.norm();
    Vec3 p = n.momentum;
    if (floor.covers(n.position, 0.0)) {
      by_floor.z() += p.z();
      p.z() = 0.0;
    }
    if (mast.covers(n.position, 0.0)) {
      const Vec3 q = n.mass * mast.constrain(n.position, p / n.mass, 0.0);
      by_mast += p - q;
      shared += floor.covers(n.position, 0.0);
    }
  }
  ASSERT_GT(shared, 0);
  EXPECT_LE((impulses[0].linear - by_floor).norm(), 1e-14 * scale);
  EXPECT_LE((impulses[1].linear - by_mast).norm(), 1e-14 * scale);
  Vec3 change = Vec3::Zero();
  for (std::size_t i = 0; i < after.size(); ++i) change += before[i].momentum - after[i].momentum;
  EXPECT_LE((impulses[0].linear + impulses[1].linear - change).norm(), 1e-14 * scale);
}

// --- mirror planes ------------------------------------------------------------------------------------------------------

/// Snow that falls on a block and on the floor, between two side walls at |y| = half_width; symmetric about x = 0 and y = 0.
struct Symmetric {
  static Case snow(const MaterialParameters& material, double half_width, bool mirror_x, bool mirror_y) {
    Case c = testing::empty_case();
    c.material = material;
    c.numerics.contact = ContactRule::nodal;  // a folded column divides by the masses of all its nodes, and round-off grows
    c.bodies = {box_body({-1.0, -0.5 * half_width, 0.65}, {1.0, 0.5 * half_width, 1.15}, {0.0, 0.0, -5.0}),
                box_body({-1.0, -half_width, 0.0}, {1.0, half_width, 0.25})};
    c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.3)};
    for (const double s : {-1.0, 1.0}) {  // what is computed has its own walls only
      if (s > 0.0 || !mirror_y) c.walls.push_back(testing::wall({0.0, half_width * s, 0.0}, {0.0, -s, 0.0}, Contact::slip));
      if (s > 0.0 || !mirror_x) c.walls.push_back(testing::wall({s, 0.0, 0.0}, {-s, 0.0, 0.0}, Contact::no_slip));
    }
    return c;
  }
  Symmetric(const MaterialParameters& material, double half_width, bool mirror_x, bool mirror_y, Transfer transfer)
      : scene(make(material, half_width, mirror_x, mirror_y, transfer)) {
    Case c = snow(material, half_width, mirror_x, mirror_y);
    c.numerics.transfer = transfer;
    state.emplace(make_state(c, scene));
    for (const Particle& p : testing::stored_particles(state->grid)) start[p.id] = position_of(p);
  }
  static CaseScene make(const MaterialParameters& material, double half_width, bool mirror_x, bool mirror_y, Transfer transfer) {
    CaseScene s = make_scene(snow(material, half_width, mirror_x, mirror_y));
    s.boundaries.emplace_back(box_between({-0.375, -0.3, -10.0}, {0.375, 0.3, 0.5}, Contact::separable, 0.2));
    s.mirror = {mirror_x, mirror_y};
    s.numerics.transfer = transfer;
    return s;
  }
  CaseScene scene;
  std::optional<State> state;
  std::map<std::uint64_t, Vec3> start;
};

struct MirrorCase {
  const char* name;
  bool x, y;
  MaterialParameters material;
  Transfer transfer;
  double half_width = 1.0;  ///< m; a wall one cell from the plane stops the image of the first node, too
};
class MirroredDomain : public ::testing::TestWithParam<MirrorCase> {};
INSTANTIATE_TEST_SUITE_P(Planes, MirroredDomain,
                         ::testing::Values(MirrorCase{"X", true, false, testing::elastic_snow(), Transfer::apic},
                                           MirrorCase{"Y", false, true, testing::elastic_snow(), Transfer::apic},
                                           MirrorCase{"XAndY", true, true, testing::elastic_snow(), Transfer::apic},
                                           MirrorCase{"XAndYCamClay", true, true, testing::cam_clay_snow(0.8, 0.3), Transfer::apic},
                                           MirrorCase{"YCamClayFlip", false, true, testing::cam_clay_snow(0.4, 0.0), Transfer::flip},
                                           MirrorCase{"YWallOneCellAway", false, true, testing::cam_clay_snow(0.8, 0.3), Transfer::apic,
                                                      dx}),
                         [](const auto& c) { return c.param.name; });

TEST_P(MirroredDomain, APartOfTheDomainMovesAsItDoesInTheWhole) {
  const MirrorCase& m = GetParam();
  Symmetric whole(m.material, m.half_width, false, false, m.transfer), part(m.material, m.half_width, m.x, m.y, m.transfer);
  ASSERT_EQ(whole.start.size(), part.start.size() * (m.x ? 2U : 1U) * (m.y ? 2U : 1U));
  // Sums in another order differ in the last bits, 1e-15 m/s of 5 m/s in a step; fifty steps may add that up and a contact pass it on:
  // 1e-12 m/s, and what follows from it over 50 steps of 1 ms, over a cell, and over E dt / dx. A fault of the mirror is of the order of
  // the values.
  const double tolerance = 1e-12;
  Vec3 whole_impulse = Vec3::Zero(), part_impulse = Vec3::Zero(), whole_moment_sum = Vec3::Zero(), part_moment = Vec3::Zero();
  for (int n = 0; n < 50; ++n) {
    const double dt = 0.9e-3;  // below the stable step at 5 m/s plus 58 m/s: 1.58 ms
    const auto a = step(*whole.state, whole.scene, dt), b = step(*part.state, part.scene, dt);
    whole_impulse += a.impulses.back().linear;
    part_impulse += b.impulses.back().linear;
    whole_moment_sum += a.impulses.back().angular;
    part_moment += b.impulses.back().angular;
  }
  std::map<std::array<long, 3>, Particle> by_start;  // in micrometres
  const auto key = [](const Vec3& x) { return std::array{std::lround(1e6 * x.x()), std::lround(1e6 * x.y()), std::lround(1e6 * x.z())}; };
  for (const Particle& p : testing::stored_particles(whole.state->grid)) by_start[key(whole.start[p.id])] = p;
  double largest_change = 0.0;
  for (const Particle& p : testing::stored_particles(part.state->grid)) {
    const Particle& q = by_start.at(key(part.start[p.id]));
    EXPECT_LE((position_of(p) - position_of(q)).norm(), tolerance * 0.05 + 1e-15);  // and an ulp of 1 m
    EXPECT_LE((velocity_of(p) - velocity_of(q)).norm(), tolerance);
    EXPECT_LE((testing::affine_of(p) - testing::affine_of(q)).norm(), tolerance * 4.0 / dx);
    EXPECT_LE((testing::stress_of(p) - testing::stress_of(q)).norm(), tolerance * 1e6 * 0.05 * 4.0 / dx);
    largest_change = std::max(largest_change, (velocity_of(p) - Vec3(0.0, 0.0, -5.0)).norm());
  }
  EXPECT_GT(largest_change, 1.0);  // it did hit
  const double scale = whole_impulse.norm();
  EXPECT_GT(scale, 100.0);  // N s
  EXPECT_LE((whole_force(part_impulse, {m.x, m.y}) - whole_impulse).norm(), 1e-12 * scale);
  EXPECT_LE((whole_moment(part_moment, {m.x, m.y}) - whole_moment_sum).norm(), 1e-12 * scale);
}

}  // namespace
}  // namespace mpm
