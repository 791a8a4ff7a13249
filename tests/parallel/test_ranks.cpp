#include <gtest/gtest.h>
#include <omp.h>

#include <bit>
#include <cstdint>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/health.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/worker.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "support/command.hpp"
#include "support/rank_cases.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"
#include "support/thread_ranks.hpp"

namespace mpm {
namespace {

/// All bytes of all particles in storage order, and every number that a caller of step() and totals() gets.
struct Outcome {
  std::vector<Particle> particles;
  std::vector<double> numbers;
  std::uint64_t moves = 0;  ///< of blocks between ranks

  void add(const Vec3& v) { numbers.insert(numbers.end(), v.data(), v.data() + 3); }
  void add(const FluxTotals& f) {
    numbers.insert(numbers.end(), {static_cast<double>(f.count), static_cast<double>(f.through_x_max), f.mass, f.energy});
    add(f.momentum);
  }
  void add(const StepReport& report) {
    numbers.push_back(report.dt);
    add(report.gravity_impulse);
    for (const Impulse& j : report.impulses) {
      add(j.linear);
      add(j.angular);
      numbers.push_back(j.work);
    }
    for (const LayerImpulses& layers : report.layers) {
      numbers.push_back(layers.first);
      for (const Vec3& v : layers.layer) add(v);
    }
    add(report.entered);
    add(report.left);
  }
  void add(const Totals& t) {
    numbers.insert(numbers.end(), {static_cast<double>(t.particles), t.mass, t.kinetic_energy, t.affine_energy, t.elastic_energy,
                                   t.potential_energy, t.momentum_scale, t.angular_momentum_scale});
    for (const Vec3& v : {t.centre, t.momentum, t.angular_momentum}) add(v);
  }
};

/// The steps of one rank, or of the first of several.
void take_steps(State& state, const Scene& scene, int steps, Outcome& outcome) {
  for (int n = 0; n < steps; ++n) {
    outcome.add(step(state, scene, stable_time_step(state, scene)));
    outcome.numbers.insert(outcome.numbers.end(), {state.max_speed, state.time, static_cast<double>(state.grid.particle_count())});
    if (n % 10 != 9) continue;
    outcome.add(totals(state, scene));
    outcome.numbers.push_back(static_cast<double>(fastest_particle(state).id));
  }
}

Outcome on_one_rank(const Case& c, int steps) {
  Outcome outcome;
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  take_steps(state, scene, steps, outcome);
  outcome.particles = testing::stored_particles(state.grid);
  return outcome;
}

Outcome on_several(const Case& c, int steps, int ranks, int threads, const Balancing& balancing) {
  Outcome outcome;
  const testing::TemporaryDirectory directory;
  testing::on_ranks(ranks, [&](Transport& transport) {
    omp_set_num_threads(threads);
    BlockExchange exchange(transport, balancing);
    if (!exchange.first()) return work_on(c, exchange);
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene, &exchange);
    take_steps(state, scene, steps, outcome);
    write_checkpoint(directory / "checkpoint.h5", c, state, {}, {});
    State all(c.numerics.cell_size, c.numerics.precision);
    RunProgress progress;
    Arrays observed;
    read_checkpoint(directory / "checkpoint.h5", c, all, progress, observed);
    outcome.particles = testing::stored_particles(all.grid);
    outcome.moves = exchange.counts().moves;
    EXPECT_LT(testing::stored_particles(state.grid).size(), outcome.particles.size());  // the others have the rest
    exchange.instruct(Task::end, state, 0.0);
  });
  omp_set_num_threads(1);
  return outcome;
}

/// Place of the first number that differs, for a message; -1: none.
std::ptrdiff_t first_difference(const std::vector<double>& a, const std::vector<double>& b) {
  const std::size_t n = std::min(a.size(), b.size());
  for (std::size_t i = 0; i < n; ++i) {
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return static_cast<std::ptrdiff_t>(i);
  }
  return a.size() == b.size() ? -1 : static_cast<std::ptrdiff_t>(n);
}

class OnRanks : public ::testing::TestWithParam<testing::NamedCase> {};
INSTANTIATE_TEST_SUITE_P(Cases, OnRanks, ::testing::ValuesIn(testing::rank_cases()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(OnRanks, EveryBitIsThatOfOneRank) {
  constexpr int steps = 60;
  const Outcome one = on_one_rank(GetParam().c, steps);
  ASSERT_FALSE(one.particles.empty());
  const Balancing seldom{}, often{.forced = 10}, measured{.threshold = 1.0, .gain = 0.0, .interval = 2};
  struct Way {
    int ranks, threads;
    Balancing balancing;
  };
  for (const Way& way : {Way{2, 1, seldom}, Way{3, 2, seldom}, Way{4, 1, seldom}, Way{2, 2, often}, Way{3, 1, often}, Way{7, 1, often},
                         Way{3, 1, measured}}) {
    const Outcome many = on_several(GetParam().c, steps, way.ranks, way.threads, way.balancing);
    EXPECT_EQ(first_difference(one.numbers, many.numbers), -1) << way.ranks << " ranks, forced " << way.balancing.forced;
    EXPECT_TRUE(testing::same_bytes(one.particles, many.particles)) << way.ranks << " ranks, forced " << way.balancing.forced;
    EXPECT_GE(many.moves, way.balancing.forced > 0 ? 3U : 0U);
  }
}

TEST(Ranks, AFaultOfOneEndsAllWithItsMessage) {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-2.0, -1.0, 0.0}, {2.0, 1.0, 2.0})};
  const CaseScene scene = make_scene(c);
  const auto spoil = [](State& state) {
    testing::change_particle(state.grid, state.next_id - 1, [](Particle& p) { p.affine[0] = std::numeric_limits<double>::quiet_NaN(); });
  };
  const auto message_of = [&](State& state) -> std::string {
    try {
      step(state, scene, 1e-3);
    } catch (const UnstableError& error) {
      return error.what();
    }
    return "";
  };
  State alone = make_state(c, scene);
  spoil(alone);
  const std::string expected = message_of(alone);
  ASSERT_NE(expected, "");
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    if (!exchange.first()) return work_on(c, exchange);  // which returns, and so does not fail alone
    State state = make_state(c, scene);
    spoil(state);
    state.grid.divide(exchange);
    EXPECT_EQ(message_of(state), expected);
    EXPECT_FALSE(exchange.busy());
    exchange.instruct(Task::end, state, 0.0);
  });
}

TEST(Ranks, ParticlesInsideABoundaryAreThoseOfAll) {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-2.0, -1.0, 0.0}, {2.0, 1.0, 2.0})};
  c.walls = {testing::wall(Vec3(0.0, 0.0, 1.0), Vec3::UnitZ(), Contact::no_slip)};  // the lower half, 8 of 16 blocks
  const CaseScene scene = make_scene(c);
  State alone = make_state(c, scene);
  step(alone, scene, 1e-4);
  const auto expected = particles_inside_boundaries(alone, scene);
  ASSERT_EQ(expected.size(), 1U);
  testing::on_ranks(4, [&](Transport& transport) {
    BlockExchange exchange(transport);
    if (!exchange.first()) return work_on(c, exchange);
    State state = make_state(c, scene);
    state.grid.divide(exchange);
    step(state, scene, 1e-4);
    EXPECT_EQ(particles_inside_boundaries(state, scene), expected);
    exchange.instruct(Task::end, state, 0.0);
  });
}

/// Messages of known size leave only when the rank that sends them waits for those of others.
class Delayed : public Transport {
 public:
  Delayed(Transport& transport, std::function<void(MessageKind)> before_wait)
      : transport_(transport), before_wait_(std::move(before_wait)) {}
  [[nodiscard]] int rank() const override { return transport_.rank(); }
  [[nodiscard]] int size() const override { return transport_.size(); }
  Messages exchange(Messages to) override { return transport_.exchange(std::move(to)); }
  void send(Messages to) override { transport_.send(std::move(to)); }
  Messages receive(std::span<const int> from) override { return transport_.receive(from); }
  void start(MessageKind kind, Messages to, const std::map<int, std::size_t>& from) override { held_[kind] = {std::move(to), from}; }
  Messages finish(MessageKind kind) override {
    before_wait_(kind);
    transport_.start(kind, std::move(held_[kind].first), held_[kind].second);
    return transport_.finish(kind);
  }
  void progress() noexcept override {}
  std::vector<Message> gather(Message mine) override { return transport_.gather(std::move(mine)); }
  void broadcast(Message& message) override { transport_.broadcast(message); }
  void maximum(std::span<double> numbers) override { transport_.maximum(numbers); }
  void sum(std::span<std::uint64_t> numbers) override { transport_.sum(numbers); }

 private:
  Transport& transport_;
  std::function<void(MessageKind)> before_wait_;
  std::map<MessageKind, std::pair<Messages, std::map<int, std::size_t>>> held_;
};

TEST(Ranks, WorkOnBlocksThatNeedNoMessagesBeforeTheyWaitForAny) {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-2.0, -3.0, 0.0}, {2.0, 1.0, 2.0}, {1.0, 0.5, 0.5})};
  const CaseScene scene = make_scene(c);
  int inner = 0, outer = 0;
  std::vector<MessageKind> waits;
  testing::on_ranks(2, [&](Transport& transport) {
    State* first = nullptr;
    std::map<std::uint64_t, Vec3> before;
    const auto position = [](const Particle& p) { return Vec3(p.position[0], p.position[1], p.position[2]); };
    Delayed delayed(transport, [&](MessageKind kind) {
      if (first == nullptr) return;
      Grid& grid = first->grid;
      waits.push_back(kind);
      for (const auto b : grid.occupied_blocks()) {
        const Block& block = grid.block(b);
        if (kind == MessageKind::parts) {  // in the first step: nodes are zero until particles add to them
          const auto& targets = block.targets();
          double mass = 0.0;
          for (const Node& node : grid.momenta(targets[forward_directions[0]]).node) mass += node[3];
          EXPECT_GT(mass, 0.0);
          for (int s = 0; s < block.particles.count(); ++s) before[block.particles[s].id] = position(block.particles[s]);
        } else {
          (block.outer ? outer : inner) += 1;
          for (int s = 0; s < block.particles.count(); ++s) {
            const Particle p = block.particles[s];
            EXPECT_EQ(position(p) == before.at(p.id), block.outer);
          }
        }
      }
    });
    BlockExchange exchange(delayed);
    if (!exchange.first()) return work_on(c, exchange);
    State state = make_state(c, scene);
    state.grid.divide(exchange);
    first = &state;
    step(state, scene, 1e-3);
    exchange.instruct(Task::end, state, 0.0);
  });
  EXPECT_EQ(waits, (std::vector{MessageKind::parts, MessageKind::nodes}));
  EXPECT_GT(inner, 0);
  EXPECT_GT(outer, 0);
}

TEST(Ranks, CountsOfARunAreWhatTheModelOfScalingReads) {
  const testing::TemporaryDirectory folder;
  const Case c = testing::rank_cases()[5].c;  // with a correction of lumped masses
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    if (!exchange.first()) return work_on(c, exchange);
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    state.grid.divide(exchange);
    Outcome outcome;
    take_steps(state, scene, 20, outcome);
    write_file(folder / "ranks.json", report_of_ranks(state, exchange));
    exchange.instruct(Task::end, state, 0.0);
  });
  const auto model = testing::run_command(
      "PYTHONPATH=" MPM_SOURCE_DIR "/python /usr/bin/python3 -m mpmtools scale . --particles 1e8 --ranks 64", folder / "", folder / "");
  EXPECT_EQ(model.code, 0) << model.err;
  EXPECT_NE(model.out.find("counted on 3 ranks"), std::string::npos) << model.out;
}

}  // namespace
}  // namespace mpm
