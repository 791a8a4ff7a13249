#include "libmpm/core/grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "libmpm/base/error.hpp"
#include "libmpm/core/transfer.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::particle_at;
using testing::position_of;
using testing::same_bytes;

constexpr double dx = 0.25;
using Oracle = std::map<std::uint64_t, Particle>;

Index3 base_of(const Vec3& x) { return {base_node(x[0] / dx), base_node(x[1] / dx), base_node(x[2] / dx)}; }
bool storage_order(const Index3& a, const Index3& b) { return std::array{a[2], a[1], a[0]} < std::array{b[2], b[1], b[0]}; }

/// Moves every particle by its own displacement, in the way grid_to_particle does: position, then the mark of the new cell.
template <class F>
void move_all(Grid& grid, Oracle& oracle, F&& displacement) {
  for (const auto b : grid.occupied_blocks()) {
    ParticleBin& bin = grid.block(b).particles;
    for (int s = 0; s < bin.count(); ++s) {
      Particle p = bin[s];
      const Vec3 x = position_of(p) + displacement(p);
      std::copy_n(x.data(), 3, p.position);
      const Index3 node = base_of(x);
      const bool stays = block_of_node(node) == grid.block(b).coordinate;
      bin.cell[static_cast<std::size_t>(s)] = stays ? static_cast<std::uint8_t>(number_of_node(node)) : ParticleBin::left_block;
      bin.set(s, p);
      oracle[p.id] = bin[s];
    }
    ASSERT_TRUE(collect_migrants(grid, b));
  }
  grid.migrate();
}

/// Everything that the header promises about a grid whose lists are fresh.
void expect_sound(const Grid& grid, const Oracle& oracle) {
  // every particle once, unchanged, in the block and the cell of its base node
  std::set<std::uint64_t> seen;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    const ParticleBin& bin = block.particles;
    ASSERT_GT(bin.count(), 0);
    ASSERT_EQ(bin.cell.size(), static_cast<std::size_t>(bin.count()));
    for (int s = 0; s < bin.count(); ++s) {
      ASSERT_TRUE(seen.insert(bin[s].id).second) << "particle " << bin[s].id << " twice";
      const auto known = oracle.find(bin[s].id);
      ASSERT_NE(known, oracle.end());
      ASSERT_TRUE(same_bytes(known->second, bin[s]));
      const Index3 node = base_of(position_of(bin[s]));
      ASSERT_EQ(block_of_node(node), block.coordinate);
      ASSERT_EQ(bin.cell[static_cast<std::size_t>(s)], number_of_node(node));
    }
    // the order by cell holds every slot once, slots of a cell ascending
    ASSERT_EQ(bin.order.size(), bin.cell.size());
    ASSERT_EQ(bin.cell_start[0], 0);
    ASSERT_EQ(bin.cell_start[block_nodes], bin.count());
    for (int c = 0; c < block_nodes; ++c) {
      for (int n = bin.cell_start[c]; n < bin.cell_start[c + 1]; ++n) {
        ASSERT_EQ(bin.cell[bin.order[static_cast<std::size_t>(n)]], c);
        if (n > bin.cell_start[c]) {
          ASSERT_LT(bin.order[static_cast<std::size_t>(n) - 1], bin.order[static_cast<std::size_t>(n)]);
        }
      }
    }
    ASSERT_EQ(block.outbox.count, 0U);
  }
  ASSERT_EQ(seen.size(), oracle.size());
  ASSERT_EQ(grid.particle_count(), oracle.size());

  // blocks: those with particles and their forward neighbours, and no others; sorted; neighbours right
  const auto less = [](const Index3& a, const Index3& b) { return storage_order(a, b); };
  std::set<Index3, decltype(less)> needed(less);
  for (const auto& [id, p] : oracle) {
    const Index3 c = block_of_node(base_of(position_of(p)));
    for (int n = 0; n < 8; ++n) needed.insert({c[0] + (n & 1), c[1] + (n >> 1 & 1), c[2] + (n >> 2)});
  }
  std::vector<Index3> there;
  for (const auto b : grid.own_blocks()) there.push_back(grid.block(b).coordinate);
  ASSERT_TRUE(std::equal(there.begin(), there.end(), needed.begin(), needed.end()));
  for (const auto b : grid.own_blocks()) {
    const Index3& c = grid.block(b).coordinate;
    ASSERT_EQ(grid.find(c), b);
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          ASSERT_EQ(grid.block(b).neighbour[static_cast<std::size_t>(direction_of(x, y, z))], grid.find({c[0] + x, c[1] + y, c[2] + z}));
        }
      }
    }
  }

  // colours: each occupied block has one; no two of one colour touch a node (6 nodes from 4 c on: apart by two blocks on some axis)
  std::size_t coloured = 0;
  for (int colour = 0; colour < 8; ++colour) {
    const auto list = grid.coloured_blocks(colour);
    coloured += list.size();
    for (std::size_t i = 0; i < list.size(); ++i) {
      ASSERT_TRUE(i == 0 || storage_order(grid.block(list[i - 1]).coordinate, grid.block(list[i]).coordinate));
      for (std::size_t j = 0; j < i; ++j) {
        const Index3 &a = grid.block(list[i]).coordinate, &b = grid.block(list[j]).coordinate;
        bool share = true;
        for (std::size_t axis = 0; axis < 3; ++axis) share = share && std::abs(a[axis] - b[axis]) * block_edge < halo_edge;
        ASSERT_FALSE(share);
      }
    }
  }
  ASSERT_EQ(coloured, grid.occupied_blocks().size());
}

class RandomWalk : public ::testing::Test {
 protected:
  void scatter(int count, double half_size) {
    std::uniform_real_distribution<double> place(-half_size, half_size);
    for (int i = 0; i < count; ++i) insert({place(random), place(random), place(random)});
    grid.refresh();
  }
  void insert(const Vec3& x) {
    Particle p = particle_at(x, next_id++);
    testing::randomise(p, random);
    grid.insert(p);
    oracle[p.id] = p;
  }
  /// Uniform in a cube of +-reach.
  Vec3 jump(double reach) {
    std::uniform_real_distribution<double> d(-reach, reach);
    return {d(random), d(random), d(random)};
  }
  std::mt19937_64 random{7};
  Grid grid{dx};
  Oracle oracle;
  std::uint64_t next_id = 0;
};

TEST_F(RandomWalk, KeepsEveryParticleExactlyOnceHoweverFastItMoves) {
  scatter(2000, 2.0);
  expect_sound(grid, oracle);
  // a particle may cross one block at most: four cells from its position, here just below
  const double reach[] = {0.01 * dx, 0.5 * dx, 3.99 * dx, 0.1 * dx};
  for (int n = 0; n < 24; ++n) {
    move_all(grid, oracle, [&](const Particle& p) { return jump(p.id % 5 == 0 ? 3.99 * dx : reach[n % 4]); });
    if (n % 4 == 3) expect_sound(grid, oracle);
    if (HasFatalFailure()) return;
  }
}

TEST_F(RandomWalk, EmptiesAndReCreatesBlocks) {
  scatter(400, 0.7);
  for (int n = 0; n < 60; ++n) {  // the cloud flies through the origin and back, block after block
    const double away = (n / 15) % 2 == 0 ? 1.0 : -1.0;
    move_all(grid, oracle, [&](const Particle&) { return Vec3(jump(0.2 * dx) + away * dx * Vec3(2.0, -3.0, 1.0)); });
    expect_sound(grid, oracle);
    if (HasFatalFailure()) return;
  }
}

TEST_F(RandomWalk, InsertsAndRemovesWhileParticlesMove) {
  scatter(500, 1.0);
  for (int n = 0; n < 40; ++n) {
    for (const auto b : grid.occupied_blocks()) {
      ParticleBin& bin = grid.block(b).particles;
      for (int s = bin.count() - 1; s >= 0; --s) {
        if (random() % 8 != 0) continue;
        oracle.erase(bin[s].id);
        grid.remove(b, s);
      }
    }
    scatter(60, 1.0);
    expect_sound(grid, oracle);
    move_all(grid, oracle, [&](const Particle&) { return jump(1.5 * dx); });
    expect_sound(grid, oracle);
    if (HasFatalFailure()) return;
  }
}

TEST_F(RandomWalk, RefreshSortsABlockInWhichOneParticleReplacedAnother) {
  for (int i = 0; i < 5; ++i) insert({0.3 + 0.1 * i, 0.3, 0.3});
  grid.refresh();
  const auto b = grid.occupied_blocks()[0];
  oracle.erase(grid.block(b).particles[1].id);
  grid.remove(b, 1);
  insert({0.9, 0.9, 0.9});  // as many as before, in other cells
  grid.refresh();
  expect_sound(grid, oracle);
}

TEST_F(RandomWalk, ParticlesOnNodesAndTiesStayInReach) {
  for (int i = -12; i <= 12; ++i) insert(Vec3(0.5 * dx * i, -0.5 * dx * i, 0.5 * dx * (i % 3)));
  grid.refresh();
  expect_sound(grid, oracle);
}

TEST(Grid, BlocksDivideTheNodesFromMinusOneOn) {
  EXPECT_EQ(node_index({0, 0, 0}, 0), (Index3{-1, -1, -1}));
  EXPECT_EQ(node_index({0, -1, 2}, 1 + 4 * 3 + 16 * 2), (Index3{0, -2, 9}));
  for (std::int32_t n = -9; n < 9; ++n) {
    const Index3 at = {n, 2 * n, -n};
    EXPECT_EQ(node_index(block_of_node(at), number_of_node(at)), at);
    EXPECT_EQ(node_position(block_of_node(at), number_of_node(at), dx), dx * Vec3(n, 2 * n, -n));
  }
}

TEST(Grid, IsEmptyWithoutParticles) {
  Grid grid(dx);
  grid.refresh();
  grid.migrate();
  EXPECT_EQ(grid.particle_count(), 0U);
  EXPECT_TRUE(grid.own_blocks().empty());
  EXPECT_EQ(grid.find({0, 0, 0}), no_block);
}

/// A flow of 20 m x 10 m x 1 m and a jet of 0.5 m x 0.5 m x 44 m.
TEST(Grid, TakesOnlyParticlesOfBlocksThatItsRankOwns) {
  class LowerHalf : public OneRank {
    [[nodiscard]] bool owns(const Index3& block) const override { return block[2] < 0; }
  } ranks;
  Grid grid(dx);
  grid.divide(ranks);
  for (const double z : {-3.0, -2.0, 2.0}) grid.insert(particle_at({0.1, 0.1, z}));
  grid.refresh();
  EXPECT_EQ(grid.particle_count(), 2U);
}

TEST(Grid, MemoryFollowsTheOccupiedVolumeAndIsGivenBack) {
  const auto fill = [](Grid& grid, double height) {
    std::uint64_t id = 0;
    for (double x = 0.0; x < 20.0; x += 0.5) {
      for (double y = 0.0; y < 10.0; y += 0.5) {
        for (double z = 0.1; z < 1.0; z += 0.25) grid.insert(particle_at({x, y, z}, id++));
      }
    }
    for (double z = 1.0; z < height; z += 0.125) {
      for (double x = 10.0; x < 10.5; x += 0.125) {
        for (double y = 5.0; y < 5.5; y += 0.125) grid.insert(particle_at({x, y, z}, id++));
      }
    }
    grid.refresh();
  };
  Grid flat(dx), with_jet(dx);
  fill(flat, 1.0);
  fill(with_jet, 45.0);
  // The jet crosses 45 m / 1 m = 45 block layers, is in at most 2 x 2 blocks of each and touches at most 3 x 3: a box would take 20 x
  // 10 x 45.
  EXPECT_LE(with_jet.own_blocks().size(), flat.own_blocks().size() + 9 * 46);
  EXPECT_GE(with_jet.own_blocks().size(), flat.own_blocks().size() + 44);
  // per block nodes, lists and neighbours; the particles' slabs and per-particle lists apart
  const std::size_t per_block = sizeof(NodeBlock) + sizeof(Block);
  const std::size_t per_particle = sizeof(Particle) * 4;  // pages are at worst a quarter full on average here; slabs of 2 MB
  EXPECT_LE(with_jet.bytes(),
            with_jet.own_blocks().size() * 2 * per_block + with_jet.particle_count() * per_particle + (std::size_t{4} << 20));

  const std::size_t before = with_jet.bytes();
  for (int round = 0; round < 3; ++round) {
    for (const auto b : with_jet.occupied_blocks()) {
      while (with_jet.block(b).particles.count() > 0) with_jet.remove(b, 0);
    }
    with_jet.migrate();
    EXPECT_TRUE(with_jet.own_blocks().empty());
    EXPECT_EQ(with_jet.particle_count(), 0U);
    fill(with_jet, 45.0);
  }
  EXPECT_LE(with_jet.bytes(), before + before / 8);  // pages, blocks and nodes were used again; lists keep a capacity
}

TEST(Grid, RestoreGivesBackTheSameSlotsCellsAndLists) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  Grid grid(dx);
  Oracle oracle;
  for (std::uint64_t i = 0; i < 700; ++i) {
    const Particle p = particle_at({place(random), place(random), place(random)}, i);
    grid.insert(p);
    oracle[i] = p;
  }
  grid.refresh();
  for (int n = 0; n < 10; ++n) {  // slots in an order that positions alone do not tell
    move_all(grid, oracle, [&](const Particle&) { return Vec3(0.5 * Vec3(place(random), place(random), place(random))); });
  }
  Grid copy(dx);
  std::vector<std::int32_t> blocks(grid.occupied_blocks().begin(), grid.occupied_blocks().end());
  std::shuffle(blocks.begin(), blocks.end(), random);  // whatever order the blocks come back in
  for (const auto b : blocks) {
    const ParticleBin& bin = grid.block(b).particles;
    std::vector<std::byte> records;
    for (int s = 0; s < bin.count(); ++s) records.insert(records.end(), bin.bytes(s).begin(), bin.bytes(s).end());
    copy.restore({grid.block(b).coordinate, bin.frame.velocity, bin.cell, records});
  }
  copy.refresh();
  expect_sound(copy, oracle);
  EXPECT_TRUE(same_bytes(testing::stored_particles(grid), testing::stored_particles(copy)));
  ASSERT_EQ(grid.own_blocks().size(), copy.own_blocks().size());
  for (std::size_t i = 0; i < grid.own_blocks().size(); ++i) {
    const Block &a = grid.block(grid.own_blocks()[i]), &b = copy.block(copy.own_blocks()[i]);
    EXPECT_EQ(a.coordinate, b.coordinate);
    EXPECT_EQ(a.particles.cell, b.particles.cell);
    EXPECT_EQ(a.particles.order, b.particles.order);
  }
}

TEST(Grid, ATooDenseBlockAndATooFarParticleAreUnstableNotACrash) {
  Grid far(dx);
  EXPECT_THROW(far.insert(particle_at({0.0, 3.0e6, 0.0})), UnstableError);
  Grid dense(dx);
  for (int i = 0; i < 66000; ++i) dense.insert(particle_at({0.5, 0.5, 0.5}, static_cast<std::uint64_t>(i)));
  EXPECT_THROW(dense.migrate(), UnstableError);
}

}  // namespace
}  // namespace mpm
