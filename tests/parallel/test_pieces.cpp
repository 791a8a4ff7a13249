#include "libmpm/driver/pieces.hpp"

#include <gtest/gtest.h>

#include <array>

#include "libmpm/core/step.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "support/rank_cases.hpp"
#include "support/solver_states.hpp"
#include "support/thread_ranks.hpp"

namespace mpm {
namespace {

/// What passed on one rank, and how large the pieces were.
struct Passed {
  std::vector<Particle> particles;
  std::size_t announced = 0, before = 0, largest = 0, pieces = 0;

  ParticleSink sink() {
    return {.begin =
                [this](std::size_t all, std::size_t of_others) {
                  announced = all;
                  before = of_others;
                },
            .append =
                [this](std::span<const Particle> piece) {
                  particles.insert(particles.end(), piece.begin(), piece.end());
                  largest = std::max(largest, piece.size());
                  ++pieces;
                }};
  }
};

/// A body of some thousand particles of which a part left the domain, so that numbers are missing.
Case body_with_gaps() {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-2.0, -1.0, 0.0}, {2.0, 1.0, 2.0})};
  c.domain.max = Vec3(1.5, 5.0, 5.0);
  return c;
}

State stepped(const Case& c, const Scene& scene, BlockExchange* ranks) {
  State scratch(c.numerics.cell_size, c.numerics.precision);
  const bool first = ranks == nullptr || ranks->first();
  if (!first) ranks->next_instruction(scratch);
  State state = make_state(c, scene, ranks);
  const double dt = first ? 1e-3 : ranks->next_instruction(state).dt;
  step(state, scene, dt);
  return state;
}

constexpr PieceSize hundred{.particles = 100};

TEST(Pieces, ParticlesOfOneRankComeByRisingNumber) {
  const Case c = body_with_gaps();
  const CaseScene scene = make_scene(c);
  const State state = stepped(c, scene, nullptr);
  const auto expected = testing::particles_by_id(state.grid);
  ASSERT_GT(expected.size(), 1000U);
  ASSERT_LT(expected.size(), state.next_id);
  Passed passed;
  pass_particles(state, passed.sink(), hundred);
  EXPECT_EQ(passed.announced, expected.size());
  EXPECT_EQ(passed.before, 0U);
  EXPECT_TRUE(testing::same_bytes(passed.particles, expected));
  EXPECT_LE(passed.largest, hundred.particles);
  EXPECT_LT(passed.pieces, 2 * expected.size() / hundred.particles) << "stretches are joined";
}

TEST(Pieces, NoParticlesAreNoPiece) {
  Passed passed;
  pass_particles(State(0.25), passed.sink());
  EXPECT_EQ(passed.announced + passed.pieces, 0U);
}

class PiecesOfRanks : public ::testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(Precisions, PiecesOfRanks, ::testing::Values(Precision::double_precision, Precision::single_precision),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST_P(PiecesOfRanks, GiveEachRankOneStretchOfTheNumbers) {
  Case c = body_with_gaps();
  c.numerics.precision = GetParam();
  const CaseScene scene = make_scene(c);
  const auto expected = testing::particles_by_id(stepped(c, scene, nullptr).grid);
  std::array<Passed, 3> passed;
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    State state = stepped(c, scene, &exchange);
    const std::uint64_t gathers = exchange.counts().gathers;
    if (!exchange.first()) exchange.next_instruction(state);
    pass_particles(state, passed[static_cast<std::size_t>(transport.rank())].sink(), hundred);
    EXPECT_EQ(exchange.counts().gathers, gathers) << "files are not counted";
    EXPECT_LT(testing::stored_particles(state.grid).size(), expected.size());
  });
  std::vector<Particle> all;
  for (const Passed& of_rank : passed) {
    EXPECT_EQ(of_rank.announced, expected.size());
    EXPECT_EQ(of_rank.before, all.size());
    EXPECT_LE(of_rank.largest, hundred.particles);
    EXPECT_GT(of_rank.pieces, 3U) << "each has about a third of them";
    all.insert(all.end(), of_rank.particles.begin(), of_rank.particles.end());
  }
  EXPECT_TRUE(testing::same_bytes(all, expected));
}

}  // namespace
}  // namespace mpm
