#include "libmpm/core/particle_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <random>

#include "libmpm/boundary/shapes/any_shape.hpp"
#include "libmpm/core/transfer.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

constexpr double dx = 0.25, base = 0.1, top = 0.9, density = 300.0;

/// Particles of random velocity in a box, sorted.
Grid grid_with_particles(const Eigen::AlignedBox3d& box, std::uint64_t count, Precision precision) {
  Grid grid(dx, precision);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> part(0.0, 1.0), v(-5.0, 5.0);
  for (std::uint64_t id = 0; id < count; ++id) {
    Particle p{};
    for (int i = 0; i < 3; ++i) p.position[i] = box.min()[i] + part(random) * box.sizes()[i];
    for (double& component : p.velocity) component = v(random);
    p.volume = 1e-3;
    p.id = id;
    grid.insert(p);
  }
  grid.migrate();
  return grid;
}

/// A shape and a precision of the particles.
class ParticleContactOf : public ::testing::TestWithParam<std::tuple<testing::TypicalShape, Precision>> {
 protected:
  const SurfaceSolid solid{{outline_of(std::get<0>(GetParam()).shape), base, top}, 0.3, Vec3(0.1, 0.2, 0.3), dx, {}};
  const std::vector<Boundary> boundaries{Wall{}, solid};
  const double single = std::get<1>(GetParam()) == Precision::single_precision ? 1.0 : 0.0;

  /// Particles around and in the solid, sorted.
  Grid filled() const { return grid_with_particles({Vec3(-0.5, -1.5, 0.01), Vec3(2.5, 1.5, 1.1)}, 4000, std::get<1>(GetParam())); }
  static std::map<std::uint64_t, Particle> particles_of(const Grid& grid) {
    std::map<std::uint64_t, Particle> all;
    for (const auto b : grid.occupied_blocks()) {
      const ParticleBin& bin = grid.block(b).particles;
      for (int s = 0; s < bin.count(); ++s) all[bin[s].id] = bin[s];
    }
    return all;
  }
};
INSTANTIATE_TEST_SUITE_P(Shapes, ParticleContactOf,
                         ::testing::Combine(::testing::ValuesIn(testing::typical_shapes()),
                                            ::testing::Values(Precision::double_precision, Precision::single_precision)),
                         [](const auto& test) {
                           return std::get<0>(test.param).name +
                                  (std::get<1>(test.param) == Precision::single_precision ? "Single" : "Double");
                         });

TEST_P(ParticleContactOf, ReturnsParticlesToTheSurfaceStopsThemAndBooksTheirMomentum) {
  Grid grid = filled();
  const auto before = particles_of(grid);
  Vec3 taken = Vec3::Zero(), moment = Vec3::Zero();
  for (const auto b : grid.occupied_blocks()) {
    for (const ParticleImpulse& t : return_to_surface(grid, b, boundaries, 0.0, density)) {
      EXPECT_EQ(t.boundary, 1U);
      EXPECT_GE(t.layer, first_node(grid.block(b).coordinate[2]));
      EXPECT_LT(t.layer, first_node(grid.block(b).coordinate[2]) + block_edge);
      taken += t.impulse.linear, moment += t.impulse.angular;
    }
    EXPECT_TRUE(collect_migrants(grid, b));
  }
  grid.migrate();
  const auto after = particles_of(grid);
  ASSERT_EQ(after.size(), before.size());

  Vec3 lost = Vec3::Zero(), turned = Vec3::Zero();
  int held = 0, corrected = 0;
  const double rounding = 1e-9 + single * 1e-6;  // of positions of some metres, velocities of some metres a second
  for (const auto& [id, was] : before) {
    const Particle& is = after.at(id);
    const UprightSolid::Nearest surface = solid.solid().nearest(position_of(was));
    const double depth = -surface.distance;
    const Vec3 change = velocity_of(was) - velocity_of(is);
    lost += density * was.volume * change;
    turned += (position_of(was) - solid.reference_point()).cross(density * was.volume * change);
    if (depth <= deepest_particle * dx) {
      EXPECT_EQ(position_of(is), position_of(was));
      EXPECT_LE(change.norm(), rounding);  // single: relative to the velocity of another block
      continue;
    }
    ++held;
    const double moved = std::min(depth, dx);
    EXPECT_LE((position_of(is) - position_of(was) - moved * surface.normal).norm(), rounding);
    const double into = -velocity_of(was).dot(surface.normal);
    EXPECT_NEAR(change.dot(surface.normal), -std::max(into, 0.0), rounding);
    EXPECT_LE((change - change.dot(surface.normal) * surface.normal).norm(), 0.3 * std::max(into, 0.0) + rounding) << "Coulomb";
    corrected += into > 0.0;
  }
  EXPECT_GT(held, 100);
  EXPECT_GT(corrected, 50);
  EXPECT_LE((taken - lost).norm(), held * density * 1e-3 * rounding);
  EXPECT_LE((moment - turned).norm(), 4.0 * held * density * 1e-3 * rounding);
}

TEST_P(ParticleContactOf, LeavesNothingBehindTheSurfaceAfterAFewSteps) {
  Grid grid = filled();
  for (int step = 0; step < 6; ++step) {  // a cell each: the shapes are at most five cells deep
    for (const auto b : grid.occupied_blocks()) {
      (void)return_to_surface(grid, b, boundaries, 0.0, density);
      collect_migrants(grid, b);
    }
    grid.migrate();
  }
  double deepest = 0.0;
  for (const auto& [id, p] : particles_of(grid)) {
    deepest = std::max(deepest, -solid.solid().nearest(position_of(p)).distance / dx);
  }
  EXPECT_LE(deepest, deepest_particle + 1e-6);
}

/// The floor z = 0 as a wall and as ground, each a belt with friction.
class ParticleBelowTheFloor : public ::testing::TestWithParam<Boundary> {};

TEST_P(ParticleBelowTheFloor, ReturnsToItBesideASolid) {
  const SurfaceSolid solid{{outline_of(testing::typical_shapes().front().shape), base, top}, 0.3, Vec3::Zero(), dx, {}};
  const std::vector<Boundary> boundaries{GetParam(), solid};
  Grid grid = grid_with_particles({Vec3(-3.0, -3.0, -0.9 * dx), Vec3(3.0, 3.0, 0.9 * dx)}, 3000, Precision::double_precision);
  int returned = 0, left_alone = 0;
  for (const auto b : grid.occupied_blocks()) {
    const ParticleBin& bin = grid.block(b).particles;
    std::vector<Particle> before;
    for (int s = 0; s < bin.count(); ++s) before.push_back(bin[s]);
    Vec3 taken = Vec3::Zero(), lost = Vec3::Zero();
    double work = 0.0, of_belt = 0.0;
    for (const ParticleImpulse& t : return_to_surface(grid, b, boundaries, 0.0, density)) {
      if (t.boundary == 0) taken += t.impulse.linear, work += t.impulse.work;
    }
    const bool beside = block_box(grid.block(b).coordinate, dx, 1.0).intersects(solid.solid().bounds());
    for (int s = 0; s < bin.count(); ++s) {
      const Particle &was = before[static_cast<std::size_t>(s)], is = bin[s];
      if (was.position[2] >= -deepest_particle * dx) continue;  // some of these are in the solid
      if (!beside) {
        EXPECT_EQ(is.position[2], was.position[2]);
        ++left_alone;
        continue;
      }
      ++returned;
      EXPECT_NEAR(is.position[2], 0.0, 1e-12);
      EXPECT_GE(is.velocity[2], 0.0);
      const Vec3 change = velocity_of(was) - velocity_of(is), slip = velocity_of(was) - Vec3(2.0, 0.0, 0.0);
      EXPECT_LE(change.head<2>().norm(), 0.4 * std::max(-was.velocity[2], 0.0) + 1e-12) << "Coulomb";
      if (was.velocity[2] < 0.0) {
        EXPECT_GT(change.head<2>().dot(slip.head<2>()), 0.0) << "towards the velocity of the belt";
      }
      lost += density * was.volume * change;
      of_belt -= density * was.volume * change.x() * 2.0;
    }
    EXPECT_LE((taken - lost).norm(), 1e-9);
    EXPECT_NEAR(work, of_belt, 1e-9);
  }
  EXPECT_GT(returned, 100);
  EXPECT_GT(left_alone, 100);
}
INSTANTIATE_TEST_SUITE_P(
    Floors, ParticleBelowTheFloor,
    ::testing::Values(
        Boundary{Wall{.contact = Contact::separable, .friction = 0.4, .velocity = {2.0, 0.0, 0.0}, .rule = ContactRule::surface}},
        Boundary{Terrain{.field = std::make_shared<HeightField>(HeightField::Points{
                             .first = {-4.0, -4.0}, .spacing = 1.0, .columns = 9, .rows = 9, .height = std::vector<double>(81)}),
                         .friction = 0.4,
                         .speed = 2.0}}),
    [](const auto& test) { return std::holds_alternative<Wall>(test.param) ? "Wall" : "Ground"; });

TEST(ParticleContact, HasNothingToDoWithoutSolids) {
  Grid grid(dx);
  Particle p{};
  p.position[0] = p.position[1] = p.position[2] = 0.1;
  p.volume = 1e-3;
  grid.insert(p);
  grid.migrate();
  EXPECT_TRUE(return_to_surface(grid, grid.occupied_blocks()[0], std::vector<Boundary>{Wall{}}, 0.0, density).empty());
}

}  // namespace
}  // namespace mpm
