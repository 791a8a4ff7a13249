#include "libmpm/driver/pieces.hpp"

#include <gtest/gtest.h>

#include <new>

#include "libmpm/base/error.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "support/rank_cases.hpp"
#include "support/solver_states.hpp"
#include "support/thread_ranks.hpp"

namespace mpm {
namespace {

/// What passed, and how large the pieces were.
struct Passed {
  std::vector<Particle> particles;
  std::vector<Index3> blocks;
  std::size_t announced = 0, largest = 0, pieces = 0;

  ParticleSink particle_sink() {
    return {.begin = [this](std::size_t n) { announced = n; },
            .append =
                [this](std::span<const Particle> piece) {
                  add({piece.begin(), piece.end()});
                }};
  }
  BlockSink block_sink() {
    return {.begin =
                [this](std::span<const BlockHead> heads) {
                  for (const BlockHead& head : heads) {
                    announced += static_cast<std::size_t>(head.count);
                    blocks.push_back(head.block);
                  }
                },
            .append = [this](const Grid& piece) { add(testing::stored_particles(piece)); }};
  }
  void add(const std::vector<Particle>& piece) {
    particles.insert(particles.end(), piece.begin(), piece.end());
    largest = std::max(largest, piece.size());
    ++pieces;
  }
};

/// A body of some thousand particles of which a part left the domain, so that numbers are missing.
Case body_with_gaps() {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-2.0, -1.0, 0.0}, {2.0, 1.0, 2.0})};
  c.domain.max = Vec3(1.5, 5.0, 5.0);
  return c;
}

State stepped(const Case& c, const Scene& scene, Ranks* ranks) {
  State state = ranks == nullptr || ranks->first() ? make_state(c, scene) : State(c.numerics.cell_size, c.numerics.precision);
  state.grid.divide(ranks);
  const double dt = ranks == nullptr || ranks->first() ? 1e-3 : ranks->next_instruction(state).dt;
  step(state, scene, dt);
  return state;
}

constexpr PieceSize hundred{.particles = 100};

TEST(Pieces, ParticlesOfOneRankComeByRisingNumber) {
  const Case c = body_with_gaps();
  const Scene scene = make_scene(c);
  const State state = stepped(c, scene, nullptr);
  const auto expected = testing::particles_by_id(state.grid);
  ASSERT_GT(expected.size(), 1000U);
  ASSERT_LT(expected.size(), state.next_id);
  Passed passed;
  pass_particles(state, passed.particle_sink(), hundred);
  EXPECT_EQ(passed.announced, expected.size());
  EXPECT_TRUE(testing::same_bytes(passed.particles, expected));
  EXPECT_LE(passed.largest, hundred.particles);
  EXPECT_LT(passed.pieces, 2 * expected.size() / hundred.particles) << "stretches are joined";
}

TEST(Pieces, NoParticlesAreAFileToo) {
  Passed particles, blocks;
  pass_particles(State(0.25), particles.particle_sink());
  pass_blocks(State(0.25), blocks.block_sink());
  EXPECT_TRUE(particles.particles.empty() && blocks.particles.empty());
}

class PiecesOfRanks : public ::testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(Precisions, PiecesOfRanks, ::testing::Values(Precision::double_precision, Precision::single_precision),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST_P(PiecesOfRanks, AreTheParticlesAndBlocksOfOneRank) {
  Case c = body_with_gaps();
  c.numerics.precision = GetParam();
  const Scene scene = make_scene(c);
  const State alone = stepped(c, scene, nullptr);
  Passed one;
  pass_blocks(alone, one.block_sink());
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    const State state = stepped(c, scene, &exchange);
    const std::uint64_t gathers = exchange.own_counts().gathers;
    Passed by_number, by_block;
    State scratch(c.numerics.cell_size, c.numerics.precision);
    if (!exchange.first()) exchange.next_instruction(scratch);
    pass_particles(state, by_number.particle_sink(), hundred);
    if (!exchange.first()) exchange.next_instruction(scratch);
    pass_blocks(state, by_block.block_sink(), hundred);
    EXPECT_FALSE(exchange.busy());
    EXPECT_EQ(exchange.own_counts().gathers, gathers) << "files are not counted";
    if (!exchange.first()) {
      EXPECT_EQ(by_number.pieces + by_block.pieces, 0U);
      return;
    }
    EXPECT_TRUE(testing::same_bytes(by_number.particles, testing::particles_by_id(alone.grid)));
    EXPECT_LE(by_number.largest, hundred.particles);
    EXPECT_EQ(by_number.announced, by_number.particles.size());
    EXPECT_TRUE(testing::same_bytes(by_block.particles, one.particles));
    EXPECT_EQ(by_block.blocks, one.blocks);
    EXPECT_GT(by_block.pieces, 5U);
  });
}

/// The sink of the first rank fails at its first piece. @returns how often it was called
template <class Failure>
int expect_failure_after_all_have_sent(BlockExchange& exchange, State& state, const Failure& failure) {
  int calls = 0;
  const auto fail = [&](const auto&) {
    ++calls;
    throw failure;
  };
  for (int way = 0; way < 2; ++way) {
    if (!exchange.first()) exchange.next_instruction(state);
    const auto pass = [&] {
      if (way == 0) pass_particles(state, {.begin = [](std::size_t) {}, .append = fail}, hundred);
      if (way == 1) pass_blocks(state, {.begin = [](std::span<const BlockHead>) {}, .append = fail}, hundred);
    };
    if (exchange.first()) {
      EXPECT_THROW(pass(), Failure);
    } else {
      EXPECT_NO_THROW(pass());
    }
    EXPECT_FALSE(exchange.busy());
  }
  return calls;
}

TEST(Pieces, AFullDiskOrAShortMemoryAtTheFirstPieceIsReportedAfterAllHaveSent) {
  const Case c = body_with_gaps();
  const Scene scene = make_scene(c);
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    State state = stepped(c, scene, &exchange);
    const int expected = exchange.first() ? 2 : 0;
    EXPECT_EQ(expect_failure_after_all_have_sent(exchange, state, IoError("full")), expected);
    EXPECT_EQ(expect_failure_after_all_have_sent(exchange, state, std::bad_alloc()), expected);
  });
}

}  // namespace
}  // namespace mpm
