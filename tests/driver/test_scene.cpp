#include "libmpm/driver/scene.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <set>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "support/solver_states.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

using testing::box_body;
using testing::empty_case;
using testing::particles_by_id;
using testing::position_of;

TEST(LatticeSpacing, IsTheCellOverTheParticlesAnAxis) {
  for (const auto& [per_cell, per_axis] : {std::pair{1, 1.0}, std::pair{8, 2.0}, std::pair{27, 3.0}, std::pair{64, 4.0}}) {
    Numerics n;
    n.cell_size = 0.3;
    n.particles_per_cell = per_cell;
    EXPECT_NEAR(n.particle_spacing(), 0.3 / per_axis, 1e-15);
  }
}

struct ShapeCase {
  BodySpec::Shape shape;
  double volume;  ///< over that of the bounding box
};
class Bodies : public ::testing::TestWithParam<ShapeCase> {};
INSTANTIATE_TEST_SUITE_P(Shapes, Bodies,
                         ::testing::Values(ShapeCase{BodySpec::Shape::box, 1.0},
                                           ShapeCase{BodySpec::Shape::cylinder, std::numbers::pi / 4.0},
                                           ShapeCase{BodySpec::Shape::sphere, std::numbers::pi / 6.0}));

TEST_P(Bodies, HaveTheExactVolumeMassAndCentreOfTheirShapeWhateverTheLattice) {
  for (const Vec3& size : {Vec3(1.0, 1.0, 1.0), Vec3(0.93, 1.31, 0.77), Vec3(0.1, 0.1, 0.1)}) {
    for (const int per_cell : {1, 8, 27}) {
      Case c = empty_case();
      c.numerics.particles_per_cell = per_cell;
      BodySpec body = box_body(Vec3(-0.4, 2.0, 0.3), Vec3(-0.4, 2.0, 0.3) + size, {1.0, 2.0, 3.0});
      body.shape = GetParam().shape;
      c.bodies = {body};
      const CaseScene scene = make_scene(c);
      const State state = make_state(c, scene);
      const double volume = GetParam().volume * size.prod();
      double sum = 0.0;
      Vec3 centre = Vec3::Zero();
      for (const Particle& p : particles_by_id(state.grid)) {
        sum += p.volume;
        centre += p.volume * position_of(p);
        EXPECT_TRUE((position_of(p).array() > body.min.array()).all() && (position_of(p).array() < body.max.array()).all());
        EXPECT_EQ(testing::velocity_of(p), body.velocity);
        for (const double s : p.stress) EXPECT_EQ(s, 0.0);
      }
      EXPECT_NEAR(sum, volume, 1e-12 * volume);
      EXPECT_NEAR(totals(state, scene).mass, 300.0 * volume, 1e-10 * volume);
      EXPECT_LE((centre / sum - 0.5 * (body.min + body.max)).norm(), 1e-12);  // lattices are symmetric
      EXPECT_NEAR(state.max_speed, body.velocity.norm(), 1e-15);
    }
  }
}

TEST_P(Bodies, OfWhichAMirrorComputesAPartHaveTheMassOfTheWhole) {
  // even and odd numbers of particles across the plane: with an odd number a layer lies on it, half of which is the image's
  for (const double half : {0.5, 0.5625, 0.4}) {
    for (const bool x : {false, true}) {
      for (const bool y : {false, true}) {
        Case c = empty_case();
        c.domain.mirror_x = x;
        c.domain.mirror_y = y;
        BodySpec body = box_body({-half, -half, 0.0}, {half, half, 1.0});
        body.shape = GetParam().shape;
        c.bodies = {body};
        const CaseScene scene = make_scene(c);
        const Totals whole = whole_of_mirrored(totals(make_state(c, scene), scene), scene.mirror);
        const double mass = 300.0 * GetParam().volume * 4.0 * half * half;
        EXPECT_NEAR(whole.mass, mass, 1e-12 * mass) << half << ' ' << x << y;
      }
    }
  }
}

TEST(Bodies, ThatTouchAMirrorPlaneAreNotHalved) {
  Case c = empty_case();
  c.domain.mirror_y = true;
  c.bodies = {box_body({0.0, 0.0, 0.0}, {1.0, 0.5, 1.0})};
  const CaseScene scene = make_scene(c);
  EXPECT_NEAR(totals(make_state(c, scene), scene).mass, 150.0, 1e-10);
}

TEST(Bodies, AreNumberedInTheirOrderXFastest) {
  Case c = empty_case();
  c.bodies = {box_body({5.0, 0.0, 0.0}, {5.5, 0.25, 0.25}), box_body({0.0, 0.0, 0.0}, {0.25, 0.25, 0.25})};
  const CaseScene scene = make_scene(c);
  const State state = make_state(c, scene);
  const auto all = particles_by_id(state.grid);
  ASSERT_EQ(all.size(), 16U + 8U);
  EXPECT_EQ(state.next_id, 24U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].id, i);
    EXPECT_EQ(all[i].position[0] > 4.0, i < 16);
  }
  EXPECT_LT(all[0].position[0], all[1].position[0]);
  EXPECT_EQ(all[0].position[1], all[3].position[1]);
  EXPECT_LT(all[3].position[1], all[4].position[1]);
  EXPECT_LT(all[7].position[2], all[8].position[2]);
}

/// A body's particles by number.
std::vector<Particle> particles_of(const BodySpec& body, const MirrorPlanes& mirror = {}) {
  Case c = empty_case();
  c.domain.mirror_x = mirror.x;
  c.domain.mirror_y = mirror.y;
  c.bodies = {body};
  return particles_by_id(make_state(c, make_scene(c)).grid);
}
BodySpec placed(Lattice lattice, BodySpec body) {
  body.lattice = lattice;
  return body;
}
double volume_of_all(const std::vector<Particle>& particles) {
  double sum = 0.0;
  for (const Particle& p : particles) sum += p.volume;
  return sum;
}
const Vec3 movements[] = {Vec3::Zero(), {3.0, 1.0, -2.0}, {0.0, -4.0, 1.0}, {1.0, 1.0, 2.0}};

TEST(AlignedBodies, AreThePlainLattice) {
  const BodySpec body = box_body({-0.4, 2.0, 0.3}, {0.53, 3.31, 1.07}, {3.0, 1.0, -2.0});
  const auto all = particles_of(body);
  const std::array<int, 3> count = {7, 10, 6};  // 0.93, 1.31 and 0.77 m over 0.125 m
  ASSERT_EQ(all.size(), 7U * 10U * 6U);
  for (const Particle& p : all) {
    const auto n = static_cast<int>(p.id);
    const std::array<int, 3> at = {n % count[0], n / count[0] % count[1], n / (count[0] * count[1])};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      const double step = (body.max[axis] - body.min[axis]) / count[i];
      EXPECT_DOUBLE_EQ(p.position[i], body.min[axis] + step * (at[i] + 0.5));  // some ulp: compilers may fuse the sum
    }
  }
}

TEST_P(Bodies, KeepTheirVolumeAndStayInside) {
  for (const Lattice lattice : {Lattice::staggered, Lattice::random}) {
    for (const Vec3& velocity : movements) {
      BodySpec body = box_body({-0.4, 2.0, 0.3}, {0.53, 3.31, 1.07}, velocity);
      body.shape = GetParam().shape;
      const auto plain = particles_of(body), shifted = particles_of(placed(lattice, body));
      if (body.shape == BodySpec::Shape::box && lattice == Lattice::staggered) {
        EXPECT_EQ(shifted.size(), plain.size());
      }
      const double volume = GetParam().volume * 0.93 * 1.31 * 0.77;
      EXPECT_NEAR(volume_of_all(shifted), volume, 1e-12 * volume);
      for (const Particle& p : shifted) {
        const Vec3 r = (2.0 * position_of(p) - body.min - body.max).cwiseQuotient(body.max - body.min);
        EXPECT_LT(r.cwiseAbs().maxCoeff(), 1.0);
        if (body.shape == BodySpec::Shape::cylinder) {
          EXPECT_LE(r.head<2>().norm(), 1.0 + 1e-12);
        }
        if (body.shape == BodySpec::Shape::sphere) {
          EXPECT_LE(r.norm(), 1.0 + 1e-12);
        }
        EXPECT_EQ(p.volume, shifted[0].volume);
        EXPECT_EQ(testing::velocity_of(p), velocity);
      }
    }
  }
}

/// 4 m are twice the points' period along x and once along the other axes: as many as cells of the lattice, none near another.
TEST(RandomBodies, AreOneParticleACellOnAverageWithALeastDistance) {
  const auto all = particles_of(placed(Lattice::random, box_body(Vec3::Zero(), Vec3(8.0, 4.0, 4.0))));
  EXPECT_EQ(all.size(), static_cast<std::size_t>(2 * random_period * random_period * random_period));
  const auto cell = [](const Particle& p) -> Vec3 { return position_of(p) / 0.125; };
  std::map<std::array<int, 3>, std::vector<Vec3>> cells;
  for (const Particle& p : all) {
    const Vec3 x = cell(p), low = x.array().floor();
    cells[{static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(low.z())}].push_back(x);
  }
  double nearest = 1.0;
  for (const auto& [at, points] : cells) {
    for (int n = 0; n < 27; ++n) {
      const auto near = cells.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
      if (near == cells.end()) continue;
      for (const Vec3& a : points)
        for (const Vec3& b : near->second) nearest = &a == &b ? nearest : std::min(nearest, (a - b).norm());
    }
  }
  EXPECT_NEAR(nearest, random_distance, 1e-3) << "among so many some are as near as they may be";
  EXPECT_LT(cells.size(), 0.85 * static_cast<double>(all.size())) << "not one in every cell";
}

/// Layers across the largest component of the velocity (across z at rest) are shifted as wholes, within a cell of the lattice and each to a
/// place of its own.
TEST(StaggeredBodies, ShiftLayersAcrossTheirMovement) {
  for (const Vec3& velocity : movements) {
    Eigen::Index axis = 2;
    if (!velocity.isZero()) velocity.cwiseAbs().maxCoeff(&axis);
    const BodySpec body = box_body(Vec3::Zero(), Vec3::Constant(2.0), velocity);  // 16 layers of 16 x 16
    const auto plain = particles_of(body), shifted = particles_of(placed(Lattice::staggered, body));
    ASSERT_EQ(plain.size(), 4096U);
    ASSERT_EQ(shifted.size(), 4096U);
    std::map<long, Vec3> shift_of;  // layers, in micrometres
    for (std::size_t i = 0; i < plain.size(); ++i) {
      const Vec3 shift = (position_of(shifted[i]) - position_of(plain[i])) / 0.125;
      EXPECT_NEAR(shift[axis], 0.0, 1e-13);
      EXPECT_LE(shift.cwiseAbs().maxCoeff(), 0.5);
      const auto [layer, made] = shift_of.try_emplace(std::lround(1e6 * plain[i].position[axis]), shift);
      EXPECT_LE((layer->second - shift).norm(), 1e-12) << "a layer is shifted as a whole";
    }
    ASSERT_EQ(shift_of.size(), 16U);
    // 16 layers spread evenly over a cell are a quarter of it apart; particles that follow one another on one line are 0 apart
    for (const auto& [a, at_a] : shift_of) {
      for (const auto& [b, at_b] : shift_of) {
        if (a == b) continue;
        const Vec3 between = at_a - at_b;
        const double apart = (between.array() - between.array().round()).matrix().norm();  // the lattice repeats
        EXPECT_GT(apart, 0.125) << a << ' ' << b;
      }
    }
  }
}

/// What is computed beyond the planes is the lattice of the whole; its image makes up the rest.
TEST_P(Bodies, AreSymmetricAboutMirrorPlanes) {
  // even and odd numbers of particles across the planes: with an odd number a layer lies on the plane, and stays there
  for (const double half : {0.5, 0.5625}) {
    for (const MirrorPlanes& mirror : {MirrorPlanes{true, false}, MirrorPlanes{false, true}, MirrorPlanes{true, true}}) {
      for (const Vec3& velocity : {Vec3(0.0, 0.0, -3.0), Vec3(3.0, 0.0, 0.0)}) {
        if (mirror.x && velocity.x() != 0.0) continue;
        BodySpec body = placed(Lattice::staggered, box_body({-half, -half, 0.0}, {half, half, 1.0}, velocity));
        body.shape = GetParam().shape;
        const auto part = particles_of(body, mirror), whole = particles_of(body);
        const double volume = GetParam().volume * 4.0 * half * half;
        EXPECT_NEAR(mirror.parts() * volume_of_all(part), volume, 1e-12 * volume);
        const bool on_planes = half > 0.53;
        double largest = 0.0;
        for (const Particle& p : part) largest = std::max(largest, p.volume);
        for (const Particle& p : part) {
          EXPECT_TRUE((!mirror.x || p.position[0] >= 0.0) && (!mirror.y || p.position[1] >= 0.0));
          const double share = (mirror.x && p.position[0] == 0.0 ? 0.5 : 1.0) * (mirror.y && p.position[1] == 0.0 ? 0.5 : 1.0);
          EXPECT_EQ(p.volume, share * largest);
          if (!on_planes) {
            EXPECT_TRUE(std::ranges::any_of(whole, [&](const Particle& q) { return position_of(p) == position_of(q); }));
          }
        }
        if (body.shape == BodySpec::Shape::box && !on_planes) {
          EXPECT_EQ(static_cast<double>(part.size()) * mirror.parts(), static_cast<double>(whole.size()));
        }
      }
    }
  }
}

TEST_P(Bodies, AtRandomHaveTheirVolumeBesideMirrorPlanes) {
  for (const double half : {0.5, 0.5625, 0.6}) {  // cells on both sides of a plane, on it, and cut by it
    for (const MirrorPlanes& mirror : {MirrorPlanes{true, false}, MirrorPlanes{false, true}, MirrorPlanes{true, true}}) {
      BodySpec body = placed(Lattice::random, box_body({-half, -half, 0.0}, {half, half, 1.0}));
      body.shape = GetParam().shape;
      const auto part = particles_of(body, mirror);
      const double volume = GetParam().volume * 4.0 * half * half;
      EXPECT_NEAR(mirror.parts() * volume_of_all(part), volume, 1e-12 * volume);
      for (const Particle& p : part) EXPECT_TRUE((!mirror.x || p.position[0] >= 0.0) && (!mirror.y || p.position[1] >= 0.0));
    }
  }
}

TEST(Bodies, WithoutAParticleAreAConfigError) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3::Zero(), Vec3(0.1, 0.1, 0.1))};
  const CaseScene scene = make_scene(c);
  EXPECT_NO_THROW(make_state(c, scene));  // however small: one particle at the centre
}

TEST(MakeScene, PutsTheObstacleLastAndSaysWhereItIs) {
  Case c = testing::small_avalanche();
  EXPECT_TRUE(std::holds_alternative<SurfaceSolid>(make_scene(c).boundaries.back()));
  c.numerics.contact = ContactRule::nodal;
  CaseScene scene = make_scene(c);
  ASSERT_TRUE(scene.obstacle);
  EXPECT_EQ(*scene.obstacle, scene.boundaries.size() - 1);
  const auto& mast = std::get<NodalSolid>(scene.boundaries.back());
  EXPECT_EQ(mast.reference, Vec3::Zero());  // foot of the front face's centre
  EXPECT_TRUE(mast.covers({0.0, 0.25, 0.0}, 0.0));
  EXPECT_TRUE(mast.covers({0.5, -0.25, 60.0}, 0.0));  // taller than any jet
  EXPECT_FALSE(mast.covers({-0.01, 0.0, 0.0}, 0.0));
  EXPECT_FALSE(mast.covers({0.51, 0.0, 0.0}, 0.0));
  EXPECT_TRUE(scene.mirror.y);
  c.obstacle.reset();
  EXPECT_FALSE(make_scene(c).obstacle);
}

TEST(ObstacleText, IsTheOutlineWithTheHeightsOfTheObstacle) {
  for (const auto& typical : testing::typical_shapes()) {
    Case c;
    c.obstacle = ObstacleSpec{.shape = typical.shape, .height = 3.0, .base = 1.0};
    const auto json = nlohmann::json::parse(obstacle_text(c));
    const Outline outline = typical.outline();
    ASSERT_EQ(json["outline_m"].size(), outline.sides().size());
    for (std::size_t i = 0; i < outline.sides().size(); ++i) {
      EXPECT_EQ(json["outline_m"][i][0], outline.sides()[i].from.x());
      EXPECT_EQ(json["outline_m"][i][1], outline.sides()[i].from.y());
    }
    EXPECT_EQ(json["top_m"], 3.0);
    EXPECT_EQ(json["base_m"], 1.0);
  }
  Case c;
  c.obstacle.emplace();
  c.arm = ArmSpec{.length = 4.0, .depth = 0.5, .base = 2.0, .height = 2.5};
  const auto tall = nlohmann::json::parse(obstacle_text(c));
  EXPECT_TRUE(tall["top_m"].is_null());
  EXPECT_FALSE(tall.contains("base_m"));
  EXPECT_EQ(tall["arm"]["outline_m"][0], nlohmann::json({0.625, -2.0}));  // the axis of the obstacle is at 0.875
  EXPECT_EQ(tall["arm"]["base_m"], 2.0);
  EXPECT_EQ(tall["arm"]["top_m"], 2.5);
}

TEST(MakeScene, ShiftsEverythingAgainstTheGridByTheOffset) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3(-2.0, -0.5, 0.5), Vec3(-1.0, 0.5, 1.5))};
  c.walls = {{.point = {0.0, 0.0, 0.1}}};
  c.obstacle = ObstacleSpec{};
  c.domain = {.min = {-3.0, -3.0, -1.0}, .max = {3.0, 3.0, 3.0}};
  c.numerics.contact = ContactRule::nodal;
  const CaseScene plain = make_scene(c);
  const State there = make_state(c, plain);
  c.numerics.grid_offset = {0.25, -0.5, 0.75};
  const CaseScene shifted = make_scene(c);
  const State state = make_state(c, shifted);
  const Vec3 by = c.numerics.cell_size * c.numerics.grid_offset;
  EXPECT_EQ(shifted.offset, by);
  EXPECT_EQ(shifted.domain_min, plain.domain_min + by);
  EXPECT_EQ(shifted.domain_max, plain.domain_max + by);
  EXPECT_EQ(std::get<Wall>(shifted.boundaries[0]).point, std::get<Wall>(plain.boundaries[0]).point + by);
  const auto& box = std::get<NodalSolid>(shifted.boundaries[1]);
  const auto& box_before = std::get<NodalSolid>(plain.boundaries[1]);
  EXPECT_EQ(box.solid.bounds().min(), box_before.solid.bounds().min() + by);
  EXPECT_EQ(box.solid.bounds().max(), box_before.solid.bounds().max() + by);
  EXPECT_EQ(box.reference, box_before.reference + by);
  const auto before = particles_by_id(there.grid), after = particles_by_id(state.grid);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(position_of(after[i]), position_of(before[i]) + by);
  // energies are those of the case: round-off of a shift by less than a metre
  EXPECT_NEAR(totals(state, shifted).potential_energy, totals(there, plain).potential_energy,
              1e-12 * std::abs(totals(there, plain).potential_energy));
}

TEST(MakeScene, RefusesToShiftAMirrorPlaneOffTheGrid) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3(0.0, 0.0, 0.0), Vec3(1.0, 1.0, 1.0))};
  c.domain.mirror_x = true;
  c.numerics.grid_offset = {0.5, 0.0, 0.0};
  EXPECT_THROW(make_scene(c), ConfigError);
  c.numerics.grid_offset = {0.0, 0.5, 0.5};
  EXPECT_NO_THROW(make_scene(c));
}

TEST(MakeScene, TiltsGravityByTheSlope) {
  Case c = empty_case();
  c.numerics.slope = std::numbers::pi / 6.0;
  const Vec3 g = make_scene(c).gravity;
  EXPECT_LE((g - 9.81 * Vec3(0.5, 0.0, -std::sqrt(0.75))).norm(), 1e-14);
}

TEST(MakeScene, TakesWallsOfAnyLength) {
  Case c = empty_case();
  WallSpec w = testing::wall(Vec3(0.0, 0.0, 1.0), Vec3::UnitZ(), Contact::slip);
  w.normal = Vec3(0.0, 0.0, 3.0);
  c.walls = {w};
  EXPECT_EQ(std::get<Wall>(make_scene(c).boundaries[0]).normal, Vec3(0.0, 0.0, 1.0));
}

TEST(MakeScene, RefusesALawWithParametersOutOfRange) {
  Case c = empty_case();
  c.material.as<HenckyElastic>().poisson_ratio = 0.5;
  EXPECT_THROW(make_scene(c), ConfigError);
}

}  // namespace
}  // namespace mpm
