#include <gmock/gmock.h>

#include <array>
#include <numeric>

#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/pieces.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/driver/worker.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "support/rank_cases.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"
#include "support/thread_ranks.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryDirectory;

constexpr int steps = 12;

void take_steps(State& state, const Scene& scene) {
  for (int n = 0; n < steps; ++n) step(state, scene, stable_time_step(state, scene));
}

/// A frame, a final state and a checkpoint in a folder.
void write_files(const std::filesystem::path& folder, const Case& c, const State& state, const Scene& scene) {
  const SnapshotInfo info{.time = state.time, .case_hash = "00", .version = "test", .reference_density = density_of(scene.material)};
  SnapshotWriter frame(SnapshotKind::frame, folder / "frame.h5", info);
  write_particles(frame, state, scene);
  SnapshotWriter final(SnapshotKind::final, folder / "final.h5", info);
  write_particles(final, state, scene);
  write_checkpoint(folder / checkpoint_file, c, state, {.samples = 3}, {{"series.time_s", {0.0, 0.1, 0.2}}});
}

void expect_same_files(const TemporaryDirectory& a, const TemporaryDirectory& b) {
  for (const char* name : {"frame.h5", "final.h5", checkpoint_file}) EXPECT_TRUE(read_file(a / name) == read_file(b / name)) << name;
}

/// Runs f(ranks) on the first of several ranks that are threads; the others take part.
template <class F>
void with_ranks(int size, const Case& c, F&& f) {
  testing::on_ranks(size, [&](Transport& transport) {
    BlockExchange exchange(transport);
    if (!exchange.first()) return work_on(c, exchange);
    f(exchange);
    exchange.instruct(Task::end, State(1.0), 0.0);
  });
}

class RankFiles : public ::testing::TestWithParam<testing::NamedCase> {};
INSTANTIATE_TEST_SUITE_P(Cases, RankFiles, ::testing::Values(testing::rank_cases()[2], testing::rank_cases()[5], testing::rank_cases()[8]),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(RankFiles, HaveTheBytesOfOneRankAlsoAfterOtherRanksWentOnFromThem) {
  const Case& c = GetParam().c;
  const CaseScene scene = make_scene(c);
  const TemporaryDirectory one, one_later, several, later;
  {
    State state = make_state(c, scene);
    take_steps(state, scene);
    write_files(one.path(), c, state, scene);
    take_steps(state, scene);
    write_files(one_later.path(), c, state, scene);
  }
  with_ranks(3, c, [&](BlockExchange& ranks) {
    State state = make_state(c, scene, &ranks);
    take_steps(state, scene);
    write_files(several.path(), c, state, scene);
  });
  expect_same_files(one, several);
  with_ranks(4, c, [&](BlockExchange& ranks) {
    State state(c.numerics.cell_size, c.numerics.precision);
    RunProgress progress;
    Arrays observed;
    read_checkpoint(several / checkpoint_file, c, state, progress, observed, &ranks);
    EXPECT_EQ(progress.samples, 3U);
    EXPECT_LT(testing::stored_particles(state.grid).size(), state.grid.particle_count());
    take_steps(state, scene);
    write_files(later.path(), c, state, scene);
  });
  expect_same_files(one_later, later);
}

TEST(DividedStart, GivesEveryRankItsShareFromTheBeginning) {
  const Case c = testing::rank_cases()[2].c;  // without joined blocks: shares are even to within half a block
  const CaseScene scene = make_scene(c);
  const std::size_t all = make_state(c, scene).grid.particle_count();
  std::array<std::size_t, 3> own{};
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    State state(c.numerics.cell_size);
    if (!exchange.first()) exchange.next_instruction(state);
    state = make_state(c, scene, &exchange);
    EXPECT_FALSE(exchange.busy());
    EXPECT_EQ(state.grid.particle_count(), all);
    own[static_cast<std::size_t>(transport.rank())] = testing::stored_particles(state.grid).size();
  });
  EXPECT_EQ(std::accumulate(own.begin(), own.end(), std::size_t{0}), all);
  for (const std::size_t n : own) EXPECT_LT(n, all / 2);  // more than a third, because blocks at the floor are joined
}

/// The newest checkpoint has a particle that is not in its cell, in a block of any rank.
TEST(RankFiles, ACheckpointThatOneRankRefusesIsReplacedByTheOneBefore) {
  const Case c = testing::rank_cases()[5].c;
  const CaseScene scene = make_scene(c);
  const TemporaryDirectory folder, expected, found;
  State alone = make_state(c, scene);
  write_checkpoint(folder / previous_checkpoint_file, c, alone, {.samples = 1}, {});
  testing::change_particle(alone.grid, alone.next_id - 1, [](Particle& p) { p.position[2] += 100.0; });
  write_checkpoint(folder / checkpoint_file, c, alone, {.samples = 2}, {});
  State state = make_state(c, scene);
  take_steps(state, scene);
  write_files(expected.path(), c, state, scene);
  with_ranks(3, c, [&](BlockExchange& ranks) {
    State resumed(c.numerics.cell_size, c.numerics.precision);
    RunProgress progress;
    const std::string message = resume_from_checkpoint(
        folder.path(), c, resumed, progress, [](const State&, const RunProgress&, const Arrays&) {}, &ranks);
    EXPECT_THAT(message, HasSubstr("is not in cell"));
    EXPECT_THAT(message, HasSubstr("going on from checkpoint.previous.h5"));
    EXPECT_EQ(progress.samples, 1U);
    take_steps(resumed, scene);
    write_files(found.path(), c, resumed, scene);
  });
  expect_same_files(expected, found);
}

}  // namespace
}  // namespace mpm
