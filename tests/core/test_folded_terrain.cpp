#include "libmpm/core/folded_terrain.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <map>
#include <numbers>

#include "libmpm/base/bspline.hpp"
#include "libmpm/core/folded_wall.hpp"
#include "support/ground.hpp"
#include "support/node_field.hpp"

namespace mpm {
namespace {

using testing::find_node;
using testing::for_each_node;
using testing::grid_of_blocks;
using testing::ground_field;
using testing::node_of;
using testing::random_node;
using testing::velocity_of;

constexpr double dx = 0.25;
constexpr double round_off = 1e-14;  ///< relative: sums of five nodes, each term with some roundings of 1.1e-16
const Index3 low = {-2, -2, -2}, high = {1, 1, 1};
const Contact kinds[] = {Contact::no_slip, Contact::slip, Contact::separable};

/// A plane through the origin's column at `height`, with slopes along both axes.
Terrain plane_ground(double height, double along_x, double along_y, Contact contact, double friction = 0.0, double speed = 0.0) {
  return {.field = ground_field([=](double x, double y) { return height + along_x * x + along_y * y; }),
          .contact = contact,
          .friction = friction,
          .speed = speed};
}
const std::pair<double, double> slopes[] = {{0.0, 0.0}, {0.2, 0.0}, {0.0, -0.57}, {-0.4, 0.4}, {0.55, 0.1}};
constexpr double heights[] = {0.0, 0.025, 0.118, 0.125, 0.133, 0.24975, -0.8125};

/// Nodes from their numbers; those that no material before the ground touches are empty: 3/2 cells in plan and in height.
template <class F>
Grid filled(const Terrain& ground, F&& f) {
  Grid grid = grid_of_blocks(dx, low, high);
  for_each_node(grid, [&](Node& n, const Index3& at) {
    n = f(at);
    const Vec3 x = dx * Vec3(at[0], at[1], at[2]);
    const HeightField::Surface surface = ground.surface(x);
    if (x.z() - surface.height < -1.5 * dx * (1.0 + surface.slope.cwiseAbs().sum()) + 1e-9) n = Node{};
  });
  return grid;
}
Grid random_grid(const Terrain& ground, unsigned seed) {
  return filled(ground, [&](const Index3& at) { return random_node(at, seed); });
}

Impulse fold(Grid& grid, const Terrain& ground, const MirrorPlanes& mirror = {}) {
  Impulse total;
  for (const Impulse& taken : apply_folded_terrain(grid, ground, mirror, grid.own_blocks())) total += taken;
  return total;
}

TEST(FoldedTerrain, ThatIsLevelIsTheWallToTheLastBit) {
  for (const double height : heights) {
    for (const Contact contact : kinds) {
      for (const double friction : {0.0, 0.3}) {
        if (contact == Contact::no_slip && friction > 0.0) continue;
        const double speed = 0.7;
        Terrain ground = plane_ground(height, 0.0, 0.0, contact, friction, speed);
        ground.translate(Vec3(0.1, -0.2, 0.05));
        const Wall wall{
            Vec3(0.1, -0.2, height + 0.05), Vec3::UnitZ(), contact, friction, Vec3(speed, 0.0, 0.0), false, ContactRule::surface};
        const auto random = [](const Index3& at) { return random_node(at, 1); };  // also deep behind
        Grid on_ground = grid_of_blocks(dx, low, high), on_wall = grid_of_blocks(dx, low, high);
        for_each_node(on_ground, [&](Node& n, const Index3& at) { n = random(at); });
        for_each_node(on_wall, [&](Node& n, const Index3& at) { n = random(at); });
        const Impulse ground_impulse = fold(on_ground, ground);
        Impulse wall_impulse;
        for (const Impulse& taken : apply_folded_wall(on_wall, wall, {}, 0.0, on_wall.own_blocks())) wall_impulse += taken;
        for_each_node(on_ground, [&](Node& n, const Index3& at) {
          EXPECT_EQ(velocity_of(n), velocity_of(*find_node(on_wall, at))) << height << ' ' << at[2];
        });
        // summed in another order: some thousand nodes of 5 N s
        EXPECT_LE((ground_impulse.linear - wall_impulse.linear).norm(), round_off * 4e4);
        EXPECT_NEAR(ground_impulse.work, wall_impulse.work, round_off * 4e4);
      }
    }
  }
}

/// What second order needs: a velocity that is tangent on the plane and linear across it is not touched, wherever the plane is.
TEST(FoldedTerrain, LetsAFieldThroughThatIsLinearFromThePlaneOn) {
  for (const auto& [along_x, along_y] : slopes) {
    for (const double height : heights) {
      for (const Contact contact : kinds) {
        const Terrain ground = plane_ground(height, along_x, along_y, contact, contact == Contact::no_slip ? 0.0 : 0.4, 0.3);
        const Vec3 normal = Vec3(-along_x, -along_y, 1.0).normalized();
        Vec3 sliding(0.7, -4.0, 2.0);
        sliding -= normal.dot(sliding) * normal;
        const auto linear = [&](const Index3& at) {
          const Vec3 x = dx * Vec3(at[0], at[1], at[2]);
          const HeightField::Surface surface = ground.surface(x);
          Vec3 v = ground.velocity(surface.slope) + Vec3(3.0, -2.0, 1.5) * (x.z() - surface.height);
          if (contact != Contact::no_slip) v += sliding;
          return node_of(v, random_node(at, 5)[3]);
        };
        Grid before = filled(ground, linear), after = filled(ground, linear);
        fold(after, ground);
        // 10 m/s; heights are rounded, 1e-16 of 4 m/s a cell
        for_each_node(before, [&, along_x = along_x](Node& n, const Index3& at) {
          if (std::abs(ground.surface(dx * Vec3(at[0], at[1], 0.0)).height) > 1.2) return;  // its master may be outside the grid
          EXPECT_LE((velocity_of(n) - velocity_of(*find_node(after, at))).norm(), 20.0 * round_off) << along_x << ' ' << height;
        });
      }
    }
  }
}

TEST(FoldedTerrain, BooksTheMomentumThatNodesLoseOnSlopesAndAtMirrorPlanes) {
  for (const MirrorPlanes& mirror : {MirrorPlanes{}, MirrorPlanes{true, true}}) {
    for (const auto& [along_x, along_y] : slopes) {
      for (const Contact contact : kinds) {
        const Terrain ground = plane_ground(0.3, along_x, along_y, contact, contact == Contact::no_slip ? 0.0 : 0.3, 0.6);
        Grid before = grid_of_blocks(dx, low, high), after = grid_of_blocks(dx, low, high);  // with deep nodes, which act alone
        for (Grid* grid : {&before, &after}) for_each_node(*grid, [](Node& n, const Index3& at) { n = random_node(at, 6); });
        const Impulse recorded = fold(after, ground, mirror);
        const testing::Taken taken = testing::taken_between(before, after, mirror, ground.reference_point());
        EXPECT_GT(recorded.linear.norm(), 0.0);
        EXPECT_LE((recorded.linear - taken.linear).norm(), round_off * taken.scale);
        EXPECT_LE((recorded.angular - taken.angular).norm(), round_off * taken.angular_scale);
        EXPECT_NEAR(recorded.work, -taken.linear.dot(ground.velocity(Vec2(along_x, along_y))), round_off * taken.scale);
      }
    }
  }
}

/// What each column of nodes gave to the ground, and its kinetic energy relative to the surface.
struct Sums {
  Vec3 given = Vec3::Zero();
  double before = 0.0, after = 0.0, scale = 0.0;
};
std::map<std::pair<int, int>, Sums> columns(Grid& before, Grid& after, const Vec3& surface = Vec3::Zero()) {
  std::map<std::pair<int, int>, Sums> all;
  for_each_node(before, [&](Node& n, const Index3& at) {
    const Node& m = *find_node(after, at);
    Sums& column = all[{at[0], at[1]}];
    column.given += n[3] * (velocity_of(n) - velocity_of(m));
    column.before += 0.5 * n[3] * (velocity_of(n) - surface).squaredNorm();
    column.after += 0.5 * n[3] * (velocity_of(m) - surface).squaredNorm();
    column.scale += n[3] * velocity_of(n).norm();
  });
  return all;
}

TEST(FoldedTerrain, NeverAddsKineticEnergyRelativeToTheSurface) {
  for (const auto& [along_x, along_y] : slopes) {
    for (const Contact contact : kinds) {
      for (const double friction : {0.0, 0.3, 5.0}) {
        if (contact == Contact::no_slip && friction > 0.0) continue;
        const Terrain ground = plane_ground(0.118, along_x, along_y, contact, friction, 0.6);
        Grid before = random_grid(ground, 7), after = random_grid(ground, 7);
        fold(after, ground);
        for (const auto& [at, column] : columns(before, after, ground.velocity(Vec2(along_x, along_y))))
          EXPECT_LE(column.after, column.before * (1.0 + 10.0 * round_off)) << friction;
      }
    }
  }
}

TEST(FoldedTerrain, PushesAlongItsNormalAndRubsWithinTheCoulombCone) {
  constexpr double mu = 0.3;
  for (const auto& [along_x, along_y] : slopes) {
    const Vec3 normal = Vec3(-along_x, -along_y, 1.0).normalized();
    const Terrain smooth = plane_ground(0.025, along_x, along_y, Contact::separable),
                  rough = plane_ground(0.025, along_x, along_y, Contact::separable, mu);
    Grid before = random_grid(smooth, 9), slid = random_grid(smooth, 9), rubbed = random_grid(smooth, 9);
    fold(slid, smooth);
    fold(rubbed, rough);
    const auto smooth_columns = columns(before, slid), rough_columns = columns(before, rubbed);
    int pushed = 0;
    for (const auto& [at, column] : rough_columns) {
      const Sums& frictionless = smooth_columns.at(at);
      const double tolerance = 10.0 * round_off * column.scale, push = -normal.dot(frictionless.given);
      EXPECT_LE((frictionless.given + push * normal).norm(), tolerance);  // along the normal alone
      EXPECT_GE(push, -tolerance);                                        // no tension
      EXPECT_NEAR(-normal.dot(column.given), push, tolerance);            // friction has no part in it
      const double rubs = (column.given + push * normal).norm();
      EXPECT_LE(rubs, mu * push + tolerance);
      pushed += push > tolerance ? 1 : 0;
    }
    EXPECT_GT(pushed, 100);
  }
}

/// Waves of 4 m length and up to 27 degrees.
double wavy(double x, double y) { return 0.2 * std::sin(0.5 * std::numbers::pi * x) * std::cos(0.5 * std::numbers::pi * y) + 0.05; }

/// The largest change of a smooth velocity that is tangent to wavy ground, with cells of a size.
double largest_change(double cell_size) {
  Terrain ground{.field = ground_field(wavy, 4.0, 0.0625), .contact = Contact::slip};  // a raster as fine as the finest grid
  const int blocks = static_cast<int>(std::lround(0.5 / cell_size));                   // 2 m to each side
  const auto smooth = [&](Node& n, const Index3& at) {
    const Vec3 x = cell_size * Vec3(at[0], at[1], at[2]);
    const HeightField::Surface surface = ground.surface(x);
    const double d = x.z() - surface.height;
    // tangent on the ground, and bent across it
    const Vec3 v = Vec3(2.0, 1.0, 2.0 * surface.slope.x() + surface.slope.y()) + Vec3(1.0, 2.0, -3.0) * (d + 0.5 * d * d);
    n = d < -1.5 * cell_size * (1.0 + surface.slope.cwiseAbs().sum()) ? Node{} : node_of(v, 1.0);
  };
  const Index3 from = {-blocks, -blocks, -1}, to = {blocks - 1, blocks - 1, 0};
  Grid before = grid_of_blocks(cell_size, from, to), after = grid_of_blocks(cell_size, from, to);
  for_each_node(before, smooth);
  for_each_node(after, smooth);
  fold(after, ground);
  double largest = 0.0;
  for_each_node(before, [&](Node& n, const Index3& at) {
    largest = std::max(largest, (velocity_of(n) - velocity_of(*find_node(after, at))).norm());
  });
  return largest;
}

TEST(FoldedTerrain, ChangesAFlowAlongCurvedGroundToSecondOrderInTheCellSize) {
  const double coarse = largest_change(0.25), middle = largest_change(0.125), fine = largest_change(0.0625);
  RecordProperty("coarse", std::to_string(coarse));
  EXPECT_GT(std::log2(coarse / middle), 1.7) << coarse << ' ' << middle << ' ' << fine;  // 2, less where the largest moves to another node
  EXPECT_GT(std::log2(middle / fine), 1.7);
  EXPECT_LT(fine, 0.1);  // m/s, of 3
}

TEST(FoldedTerrain, IsTheSameOnAnyNumberOfThreads) {
  const Terrain ground{.field = ground_field(wavy, 4.0, 0.5), .contact = Contact::separable, .friction = 0.2};
  Grid one = random_grid(ground, 11), four = random_grid(ground, 11);
  const auto first = apply_folded_terrain(one, ground, {}, one.own_blocks());
  omp_set_num_threads(4);
  const auto second = apply_folded_terrain(four, ground, {}, four.own_blocks());
  omp_set_num_threads(1);
  for_each_node(one, [&](Node& n, const Index3& at) { EXPECT_EQ(velocity_of(n), velocity_of(*find_node(four, at))); });
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].linear, second[i].linear);
}

TEST(FoldedTerrain, ReachesWithItsColumnsNoFurtherThanItsLayers) {
  Terrain ground{.field = ground_field(wavy, 4.0, 0.5), .contact = Contact::no_slip};
  for (const double shift : {0.0, 0.61, -3.3}) {
    ground.shift = Vec3(0.0, 0.0, shift);
    const LayerRange layers = layers_of_columns(ground, dx);
    // every node that is changed together with others lies in them; deep ones act alone
    Grid before = grid_of_blocks(dx, {-2, -2, -6}, {1, 1, 3}), after = grid_of_blocks(dx, {-2, -2, -6}, {1, 1, 3});
    for (Grid* grid : {&before, &after}) {
      for_each_node(*grid, [&](Node& n, const Index3& at) {
        const Vec3 x = dx * Vec3(at[0], at[1], at[2]);
        n = x.z() - ground.surface(x).height < -4.0 * dx ? Node{} : random_node(at, 12);
      });
    }
    fold(after, ground);
    for_each_node(before, [&](Node& n, const Index3& at) {
      if (velocity_of(n) == velocity_of(*find_node(after, at))) return;
      EXPECT_GE(block_of_node(at[2]), layers.first);
      EXPECT_LE(block_of_node(at[2]), layers.last);
    });
  }
}

}  // namespace
}  // namespace mpm
