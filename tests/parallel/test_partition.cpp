#include "libmpm/parallel/ownership.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "support/rank_cases.hpp"

namespace mpm {
namespace {

TEST(MortonKey, IsDifferentForEveryBlockAndOrderedWithinCubes) {
  std::set<std::uint64_t> keys;
  for (int z = -4; z < 4; ++z) {
    for (int y = -4; y < 4; ++y) {
      for (int x = -4; x < 4; ++x) keys.insert(morton_key({x, y, z}));
    }
  }
  EXPECT_EQ(keys.size(), 512U);
  // the eight blocks of an aligned cube follow one another on the curve
  for (const int low : {-4, -2, 0, 2}) {
    const std::uint64_t first = morton_key({low, low, low});
    for (int n = 0; n < 8; ++n)
      EXPECT_EQ(morton_key({low + (n & 1), low + (n >> 1 & 1), low + (n >> 2)}), first + static_cast<std::uint64_t>(n));
  }
  EXPECT_LT(morton_key({-1, -1, -1}), morton_key({0, 0, 0}));
  constexpr std::int32_t far = (1 << 20) - 1;  // the ends of what the grid reaches
  EXPECT_LT(morton_key({-far, -far, -far}), morton_key({far, far, far}));
}

TEST(Curve, EveryCurveGivesEveryBlockItsOwnKeyUpToTheEndsOfTheGrid) {
  constexpr std::int32_t far = (1 << 20) - 1;
  for (const Curve& curve : Curve::all()) {
    std::set<std::uint64_t> keys;
    for (const int z : {-far, -2, -1, 0, 1, far}) {
      for (const int y : {-far, -2, -1, 0, 1, far}) {
        for (const int x : {-far, -2, -1, 0, 1, far}) keys.insert(curve.key({x, y, z}));
      }
    }
    EXPECT_EQ(keys.size(), 216U);
    EXPECT_LT(*keys.rbegin(), std::uint64_t{1} << 63);  // below the cuts of ranks without blocks
  }
}

TEST(Curve, SweepsAndColumnsOrderBlocksByTheirFirstAxes) {
  const auto curves = Curve::all();
  ASSERT_EQ(curves.size(), 10U);
  const Curve columns = curves[1], layers = curves[4];  // along z; x, then y, then z
  EXPECT_LT(columns.key({0, 0, 900}), columns.key({1, 0, -900}));
  EXPECT_LT(columns.key({1, 0, 900}), columns.key({0, 1, -900}));
  EXPECT_LT(layers.key({0, 900, 900}), layers.key({1, -900, -900}));
  EXPECT_LT(layers.key({0, 0, 900}), layers.key({0, 1, -900}));
}

std::vector<Load> random_loads(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const auto coordinate = [&] { return static_cast<int>(random() % 10) - 5; };
  std::vector<Load> loads;
  for (std::size_t i = 0; i < count; ++i) {
    const Index3 block = {coordinate(), coordinate(), coordinate()};
    loads.push_back({block, 1.0 + static_cast<double>(random() % 500)});
  }
  return loads;
}

TEST(Partition, GivesEveryRankItsShareToWithinOnePiece) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto loads = random_loads(400, seed);
    const std::vector<double> shares = {1.0, 2.0, 1.0, 0.5, 3.0};
    for (const Curve& curve : Curve::all()) {
      Partition partition(5);
      partition.set(curve, std::vector<std::uint64_t>(4));
      std::map<std::uint64_t, double> pieces;
      double all = 0.0, largest_piece = 0.0;
      for (const Load& l : loads) all += l.cost, pieces[partition.key(l.block)] += l.cost;
      for (const auto& [key, cost] : pieces) largest_piece = std::max(largest_piece, cost);
      partition.cut(loads, shares);
      ASSERT_EQ(partition.cuts().size(), shares.size() - 1);
      EXPECT_TRUE(std::ranges::is_sorted(partition.cuts()));
      std::vector<double> got(shares.size(), 0.0);
      for (const Load& l : loads) got[static_cast<std::size_t>(partition.owner(l.block))] += l.cost;
      for (std::size_t r = 0; r < shares.size(); ++r)
        EXPECT_NEAR(got[r], all * shares[r] / 7.5, largest_piece);  // half a piece at each cut
      EXPECT_EQ(partition.largest_cost(loads), *std::ranges::max_element(got));
    }
  }
}

TEST(Partition, LeavesRanksEmptyWhereThereAreTooFewPieces) {
  const std::vector<double> shares(6, 1.0);
  const std::vector<Load> loads = {{{0, 0, 0}, 1.0}, {{1, 0, 0}, 1.0}};
  Partition partition(6);
  partition.cut(loads, shares);
  EXPECT_EQ(partition.largest_cost(loads), 1.0);
  partition.cut({}, shares);
  EXPECT_EQ(partition.cuts().size(), 5U);
}

/// All blocks of a box, with equal costs.
std::vector<Load> box_of_loads(const Index3& edges) {
  std::vector<Load> loads;
  for (int z = 0; z < edges[2]; ++z) {
    for (int y = 0; y < edges[1]; ++y) {
      for (int x = 0; x < edges[0]; ++x) loads.push_back({{x - 3, y, z}, 1.0});
    }
  }
  return loads;
}

double blocks_at_border(const Partition& partition, const std::vector<Load>& loads) {
  return static_cast<double>(std::ranges::count_if(loads, [&](const Load& l) { return partition.at_border(l.block); }));
}

TEST(Partition, CutsALongBoxAcrossItsLength) {
  // whatever the axis, two ranks have two layers of blocks at their border: the fewest that are possible
  for (const Index3& edges : {Index3{12, 5, 3}, Index3{5, 3, 12}, Index3{3, 12, 5}}) {
    const auto loads = box_of_loads(edges);
    Partition partition(2);
    partition.choose_curve(loads, std::vector<double>(2, 1.0));
    EXPECT_EQ(partition.largest_cost(loads), 90.0);
    EXPECT_EQ(blocks_at_border(partition, loads), 2.0 * 15.0);
  }
}

TEST(Partition, CountsBlocksAtABorderWithTheGivenPartOfTheirCostMore) {
  const auto loads = box_of_loads({12, 5, 3});
  Partition partition(2);
  partition.choose_curve(loads, std::vector<double>(2, 1.0));
  EXPECT_DOUBLE_EQ(partition.largest_cost(loads, 0.5), 90.0 + 0.5 * 15.0);
}

TEST(Partition, GivesAllBlocksToTheFirstRankAtTheStart) {
  const Partition partition(4);
  for (const int x : {-1000000, -1, 0, 5, 1000000}) EXPECT_EQ(partition.owner({x, -x, x}), 0);
}

}  // namespace
}  // namespace mpm
