#include "libmpm/parallel/partition.hpp"

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

std::vector<Load> random_loads(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Load> loads;
  for (std::size_t i = 0; i < count; ++i) loads.push_back({random() % (3 * count), 1.0 + static_cast<double>(random() % 500)});
  return loads;
}

TEST(Partition, GivesEveryRankItsShareToWithinOnePiece) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto loads = random_loads(400, seed);
    std::map<std::uint64_t, double> pieces;
    double all = 0.0, largest_piece = 0.0;
    for (const Load& l : loads) all += l.cost, pieces[l.key] += l.cost;
    for (const auto& [key, cost] : pieces) largest_piece = std::max(largest_piece, cost);
    const std::vector<double> shares = {1.0, 2.0, 1.0, 0.5, 3.0};
    const auto cuts = Partition::cut(loads, shares);
    ASSERT_EQ(cuts.size(), shares.size() - 1);
    EXPECT_TRUE(std::ranges::is_sorted(cuts));
    std::vector<double> got(shares.size(), 0.0);
    for (const Load& l : loads) got[static_cast<std::size_t>(std::ranges::upper_bound(cuts, l.key) - cuts.begin())] += l.cost;
    for (std::size_t r = 0; r < shares.size(); ++r) EXPECT_NEAR(got[r], all * shares[r] / 7.5, largest_piece);  // half a piece at each cut
    EXPECT_EQ(Partition::largest_cost(loads, cuts), *std::ranges::max_element(got));
  }
}

TEST(Partition, LeavesRanksEmptyWhereThereAreTooFewPieces) {
  const std::vector<double> shares(6, 1.0);
  const auto cuts = Partition::cut({{7, 1.0}, {9, 1.0}}, shares);
  EXPECT_EQ(Partition::largest_cost(std::vector<Load>{{7, 1.0}, {9, 1.0}}, cuts), 1.0);
  EXPECT_EQ(Partition::cut({}, shares).size(), 5U);
}

TEST(Partition, GivesAllBlocksToTheFirstRankAtTheStart) {
  const Partition partition(4);
  for (const int x : {-1000000, -1, 0, 5, 1000000}) EXPECT_EQ(partition.owner({x, -x, x}), 0);
}

}  // namespace
}  // namespace mpm
