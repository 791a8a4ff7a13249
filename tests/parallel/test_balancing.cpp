#include "libmpm/parallel/balancing.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "libmpm/core/step.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "support/rank_cases.hpp"
#include "support/solver_states.hpp"
#include "support/thread_ranks.hpp"

namespace mpm {
namespace {

constexpr int ranks = 4;
/// @param ratio  largest cost / mean cost
Evenness evenness(double ratio) { return {1000, 1.0, ratio / ranks}; }

TEST(BalancingTrials, StartWithTheFirstStep) {
  const BalancingTrials trials({}, ranks);
  EXPECT_TRUE(trials.due(0, {}));
}

TEST(BalancingTrials, NeedAnImbalanceAboveTheThreshold) {
  const BalancingTrials trials({.threshold = 1.2}, ranks);
  EXPECT_FALSE(trials.due(1000, evenness(1.19)));
  EXPECT_TRUE(trials.due(1000, evenness(1.21)));
}

TEST(BalancingTrials, TakeCutsThatLowerTheLargestCostEnough) {
  const BalancingTrials trials({.gain = 0.05}, ranks);
  EXPECT_FALSE(trials.worthwhile(1.0, 0.96));
  EXPECT_TRUE(trials.worthwhile(1.0, 0.94));
}

TEST(BalancingTrials, AreAtLeastAnIntervalApart) {
  BalancingTrials trials({.interval = 50}, ranks);
  trials.note(100, true);
  EXPECT_FALSE(trials.due(149, evenness(2.0)));
  EXPECT_TRUE(trials.due(150, evenness(2.0)));
}

TEST(BalancingTrials, BecomeRareWhereJoinedBlocksPreventAGainAndFrequentAgainAfterOne) {
  BalancingTrials trials({.interval = 50, .longest = 1600}, ranks);
  std::uint64_t step = 0;
  int count = 0;
  for (; step < 100000; ++step) {
    if (!trials.due(step, evenness(2.0))) continue;
    trials.note(step, false);
    ++count;
  }
  EXPECT_NEAR(count, 62, 5);  // 100000 / 1600; the first five follow after 50, 100, 200, 400 and 800 steps
  trials.note(step, true);
  EXPECT_TRUE(trials.due(step + 50, evenness(2.0)));
}

TEST(BalancingTrials, ForcedTrialsComeAtFixedStepsAndAreAlwaysTaken) {
  const BalancingTrials trials({.forced = 10}, ranks);
  EXPECT_TRUE(trials.due(20, evenness(1.0)) && trials.worthwhile(1.0, 3.0));
  EXPECT_FALSE(trials.due(21, evenness(9.0)));
}

/// A body of 4 x 4 x 2 blocks.
Case wide_body() {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-2.0, -2.0, 0.0}, {2.0, 2.0, 2.0}, {1.0, 0.5, 0.0})};
  return c;
}

TEST(BlockCosts, AreMeasuredOrThoseOfAsManyOtherParticles) {
  const Case c = wide_body();
  const CaseScene scene = make_scene(c);
  const State state = make_state(c, scene);
  const auto blocks = state.grid.occupied_blocks();
  const auto particles = [&](std::size_t i) { return state.grid.block(blocks[i]).particles.count(); };
  BlockCosts costs;
  costs.reserve(state.grid.index_end());
  const auto before = costs.of_occupied_blocks(state.grid);
  EXPECT_DOUBLE_EQ(before[1] / before[0], static_cast<double>(particles(1)) / particles(0));
  costs.note(state.grid.block(blocks[0]), blocks[0], particles(0), 3e-7 * particles(0));
  const auto after = costs.of_occupied_blocks(state.grid);
  ASSERT_EQ(after.size(), blocks.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_DOUBLE_EQ(after[i], 3e-7 * particles(i));
}

TEST(BlockCosts, IncludeWhatARankComputesBesidesTheMotionOfParticles) {
  const Case c = wide_body();
  const CaseScene scene = make_scene(c);
  const State state = make_state(c, scene);
  const auto sum = [&](const BlockCosts& costs) {
    const std::vector<double> all = costs.of_occupied_blocks(state.grid);
    return std::accumulate(all.begin(), all.end(), 0.0);
  };
  BlockCosts costs;
  costs.reserve(state.grid.index_end());
  for (const auto b : state.grid.occupied_blocks()) costs.note(state.grid.block(b), b, 1, 1e-6);
  const double particles_alone = sum(costs);
  for (int n = 0; n < 30; ++n) costs.note_step(2.5 * particles_alone, sum(costs));
  EXPECT_NEAR(sum(costs), 2.5 * particles_alone, 1e-6 * particles_alone);
}

/// A rank that knows only the times it is given.
class NothingMeasured : public BlockExchange {
 public:
  using BlockExchange::BlockExchange;
  [[nodiscard]] bool measures() const override { return false; }
};

TEST(Balancing, MovesBlocksAwayFromARankWhoseParticlesTakeLonger) {
  constexpr double slowness = 9.0;
  const Case c = wide_body();
  double before[2] = {}, after[2] = {};  // cost of the particles of each rank
  testing::on_ranks(2, [&](Transport& transport) {
    NothingMeasured exchange(transport, {.threshold = 1.05, .gain = 0.0, .interval = 1});
    const CaseScene scene = make_scene(c);
    State state = exchange.first() ? make_state(c, scene) : State(c.numerics.cell_size, c.numerics.precision);
    state.grid.divide(exchange);
    const auto weight = [&](const Block& block) { return block.coordinate[1] < 0 ? slowness : 1.0; };
    const auto cost = [&] {
      double sum = 0.0;
      for (const auto b : state.grid.occupied_blocks()) sum += weight(state.grid.block(b)) * state.grid.block(b).particles.count();
      return sum;
    };
    const auto take_step = [&] {
      if (exchange.first()) {
        step(state, scene, 1e-4);
      } else {
        step(state, scene, exchange.next_instruction(state).dt);
      }
    };
    take_step();  // the first cuts, by numbers of particles
    before[transport.rank()] = cost();
    for (const auto b : state.grid.occupied_blocks()) {  // often, so that they replace what was measured
      const Block& block = state.grid.block(b);
      for (int n = 0; n < 40; ++n) exchange.note_time(block, b, 1, 1e-6 * weight(block));
    }
    state.grid.refresh();
    take_step();
    after[transport.rank()] = cost();
  });
  const double half = 0.5 * (after[0] + after[1]);
  constexpr double half_a_block = 0.5 * 512.0 * slowness;  // a cut passes between blocks of at most 512 particles
  EXPECT_GT(std::max(before[0], before[1]), half + half_a_block);
  EXPECT_NEAR(after[0], half, half_a_block);
}

}  // namespace
}  // namespace mpm
