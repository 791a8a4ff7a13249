#include "libmpm/core/joined_blocks.hpp"

#include <gtest/gtest.h>

#include <set>

#include "libmpm/driver/scene.hpp"
#include "support/rank_cases.hpp"

namespace mpm {
namespace {

constexpr double dx = 0.25;

Index3 representative_of_node(const JoinedBlocks& joined, const Index3& node) {
  return joined.representative({node[0] >> 2, node[1] >> 2, node[2] >> 2});
}

Scene scene_with(std::vector<Boundary> boundaries, const MirrorPlanes& mirror = {}) {
  Scene scene{.material = HenckyElastic(HenckyElastic::Parameters{})};
  scene.boundaries = std::move(boundaries);
  scene.mirror = mirror;
  return scene;
}

Wall floor_at(double z, const Vec3& normal = Vec3::UnitZ()) {
  return {z * normal, normal, Contact::separable, 0.0, Vec3::Zero(), false, ContactRule::surface};
}

TEST(JoinedBlocks, JoinNothingWithoutReason) {
  const JoinedBlocks joined(scene_with({Wall{}}), dx, 0.0);  // acts on nodes
  EXPECT_EQ(joined, JoinedBlocks());
  EXPECT_EQ(joined.representative({3, -4, 5}), (Index3{3, -4, 5}));
}

TEST(JoinedBlocks, HoldTheColumnsOfAFoldedWallTogether) {
  // wherever the wall stands: the master is the first node half a cell before it, two more follow behind
  for (int step = -40; step < 40; ++step) {
    const double z = 0.1 * dx * step;
    const JoinedBlocks joined(scene_with({floor_at(z)}), dx, 0.0);
    const auto master = static_cast<std::int32_t>(std::ceil(z / dx + 0.5 - 1e-9));
    const Index3 first = representative_of_node(joined, {5, -7, master});
    for (int k = 1; k < 3; ++k) EXPECT_EQ(representative_of_node(joined, {5, -7, master - k}), first) << z;
    EXPECT_NE(representative_of_node(joined, {5, -7, master + 8}), first) << z;
    EXPECT_NE(representative_of_node(joined, {9, -7, master}), first) << z;
  }
}

TEST(JoinedBlocks, FollowATravellingWall) {
  Wall piston = floor_at(0.0);
  piston.travels = true;
  piston.velocity = Vec3(0.0, 0.0, 1.0);
  const Scene scene = scene_with({piston});
  EXPECT_EQ(JoinedBlocks(scene, dx, 0.0), JoinedBlocks(scene_with({floor_at(0.0)}), dx, 0.0));
  EXPECT_EQ(JoinedBlocks(scene, dx, 1.0), JoinedBlocks(scene_with({floor_at(1.0)}), dx, 0.0));
  EXPECT_NE(JoinedBlocks(scene, dx, 0.0), JoinedBlocks(scene, dx, 1.0));
}

TEST(JoinedBlocks, HoldBothSidesOfAMirrorTogether) {
  const JoinedBlocks joined(scene_with({}, {true, true}), dx, 0.0);
  const Index3 corner = joined.representative({0, 0, 2});
  for (const Index3& other : {Index3{-1, 0, 2}, Index3{0, -1, 2}, Index3{-1, -1, 2}}) EXPECT_EQ(joined.representative(other), corner);
  EXPECT_NE(joined.representative({1, 0, 2}), corner);
}

TEST(JoinedBlocks, HoldAllThatASolidCorrectsTogether) {
  int solids = 0;
  for (const auto& [name, c] : testing::rank_cases()) {
    if (c.numerics.contact != ContactRule::surface || !c.obstacle) continue;
    ++solids;
    const CaseScene scene = make_scene(c);
    const auto& solid = std::get<SurfaceSolid>(scene.boundaries[*scene.obstacle]);
    const double cell = c.numerics.cell_size;
    const JoinedBlocks joined(scene, cell, 0.0);
    const LumpedMassCorrection correction(solid, cell, 1.0, 0.0);
    std::set<Index3> together;  // nodes of the stencil, and those that a particle with a share touches
    for (const int layer : {-1, 7, 40}) {
      for (const auto& node : solid.stencil().nodes) together.insert(representative_of_node(joined, {node.at[0], node.at[1], layer}));
      for (double x = -30.0; x < 30.0; x += 0.7) {
        for (double y = -30.0; y < 30.0; y += 0.7) {
          if (correction.share({cell * x, cell * y, 0.0}) == 0.0) continue;
          const auto base = [](double at) { return static_cast<std::int32_t>(std::floor(at - 0.5)); };
          for (const int more : {0, 2}) together.insert(representative_of_node(joined, {base(x) + more, base(y) + more, layer}));
        }
      }
    }
    EXPECT_EQ(together.size(), 1U) << name;
    EXPECT_NE(representative_of_node(joined, {200, 200, 7}), *together.begin()) << name;
  }
  EXPECT_GE(solids, 2);
}

}  // namespace
}  // namespace mpm
