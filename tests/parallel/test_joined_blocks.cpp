#include "libmpm/parallel/joined_blocks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "libmpm/driver/scene.hpp"
#include "support/rank_cases.hpp"

namespace mpm {
namespace {

constexpr double dx = 0.25;

Index3 representative_of_node(const JoinedBlocks& joined, const Index3& node) { return joined.representative(block_of_node(node)); }

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
  // for any position of the wall: the master is the first node half a cell before it, two more follow behind
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
  EXPECT_EQ(JoinedBlocks(scene, dx, 0.5), JoinedBlocks(scene_with({floor_at(0.5)}), dx, 0.0));
  EXPECT_NE(JoinedBlocks(scene, dx, 0.0), JoinedBlocks(scene, dx, 0.5));
}

TEST(JoinedBlocks, WallsAndMirrorPlanesAtTheOriginJoinNothing) {
  EXPECT_EQ(JoinedBlocks(scene_with({floor_at(0.0)}, {true, true}), dx, 0.0), JoinedBlocks());
  for (const std::int32_t node : {-1, 0, 1}) EXPECT_EQ(block_of_node(node), 0);  // all that a particle at the plane touches
}

TEST(JoinedBlocks, HoldEachStencilOfASolidTogetherInPairsOfLayers) {
  for (const auto& [name, c] : testing::rank_cases()) {
    if (c.numerics.contact != ContactRule::surface || !c.obstacle) continue;
    const CaseScene scene = make_scene(c);
    const double cell = c.numerics.cell_size;
    const JoinedBlocks joined(scene, cell, 0.0);
    const auto& solid = std::get<SurfaceSolid>(scene.boundaries[*scene.obstacle]);
    std::set<Index3> apart;
    for (int pair = -1; pair < 6; ++pair) {
      std::set<Index3> together;
      for (const auto& node : solid.stencil().nodes) {
        for (int layer = first_node(2 * pair); layer < first_node(2 * pair + 2); ++layer)
          together.insert(representative_of_node(joined, {node.at[0], node.at[1], layer}));
      }
      EXPECT_EQ(together.size(), 1U) << name;
      apart.insert(*together.begin());
    }
    EXPECT_GE(apart.size(), 4U) << name;  // floor and top join some, not all
    for (const auto& [face, up] : {std::pair{solid.solid().top, 1}, {solid.solid().base, -1}}) {
      if (!std::isfinite(face)) continue;
      const auto master = up * static_cast<std::int32_t>(std::ceil(up * face / cell + 0.5 - 1e-9));
      const auto last = static_cast<std::int32_t>(std::floor(up * face / cell + 1e-9));  // layer of nodes inside
      for (const auto& column : solid.stencil().columns) {
        const auto& at = solid.stencil().nodes[static_cast<std::size_t>(column.node)].at;
        EXPECT_EQ(representative_of_node(joined, {at[0], at[1], master}), representative_of_node(joined, {at[0], at[1], master - 2 * up}))
            << name;
        const Index3 bounding = representative_of_node(joined, {at[0], at[1], up * (last - 1)});
        for (const int bounded : {last, last + 1})
          EXPECT_EQ(representative_of_node(joined, {at[0], at[1], up * bounded}), bounding) << name;
      }
    }
  }
}

}  // namespace
}  // namespace mpm
