#include <gtest/gtest.h>
#include <omp.h>

#include "libmpm/driver/run.hpp"
#include "support/command.hpp"
#include "support/rank_cases.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// All bytes of all particles in storage order, and what else a state holds, after some steps.
struct Outcome {
  std::vector<Particle> particles;
  std::vector<double> numbers;
};

Outcome run(const Case& c, int threads, int steps) {
  omp_set_num_threads(threads);
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  Outcome outcome;
  for (int n = 0; n < steps; ++n) {
    const StepReport report = step(state, scene, stable_time_step(state, scene));
    for (const Impulse& j : report.impulses) {
      for (int i = 0; i < 3; ++i) outcome.numbers.insert(outcome.numbers.end(), {j.linear[i], j.angular[i]});
    }
    outcome.numbers.insert(outcome.numbers.end(), {report.dt, report.gravity_impulse.z(), report.left.mass, report.left.momentum.x(),
                                                   state.max_speed, state.time});
  }
  outcome.particles = testing::stored_particles(state.grid);
  omp_set_num_threads(1);
  return outcome;
}

void expect_same_bits(const Case& c, int steps, std::initializer_list<int> thread_numbers) {
  const Outcome one = run(c, 1, steps);
  ASSERT_FALSE(one.particles.empty());
  for (const int threads : thread_numbers) {
    const Outcome many = run(c, threads, steps);
    EXPECT_EQ(one.numbers, many.numbers) << threads;
    EXPECT_TRUE(testing::same_bytes(one.particles, many.particles)) << threads;
  }
}

class SameBits : public ::testing::TestWithParam<testing::NamedCase> {};
INSTANTIATE_TEST_SUITE_P(Cases, SameBits, ::testing::ValuesIn(testing::repeatable_cases()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(SameBits, OnAnyNumberOfThreads) { expect_same_bits(GetParam().c, 60, {2, 3, 4, 8}); }

/// Runs to `samples` samples and stops there, or to the end.
void run_stretch(Case c, const std::filesystem::path& out, int threads, bool resume, int samples, double duration) {
  c.output.duration = duration;
  RunOptions options{.out = out, .threads = threads, .resume = resume};
  options.poll = [left = samples]() mutable { return --left == 0 ? Request::stop : Request::none; };
  run_case(c, options);
  omp_set_num_threads(1);
}

TEST_P(SameBits, ResumedAndExtendedOnOtherNumbersOfThreads) {
  const testing::TemporaryDirectory directory;
  const Case& c = GetParam().c;
  const double duration = c.output.duration;
  constexpr int all = -1;
  run_stretch(c, directory / "whole", 1, false, all, duration);
  run_stretch(c, directory / "resumed", 2, false, 1, duration);  // final.h5 is not there yet: it was stopped
  EXPECT_FALSE(std::filesystem::exists(directory / "resumed/final.h5"));
  run_stretch(c, directory / "resumed", 3, true, 1, duration);
  run_stretch(c, directory / "resumed", 1, true, all, duration);
  run_stretch(c, directory / "extended", 4, false, all, duration / 3.0);
  run_stretch(c, directory / "extended", 8, true, all, duration);
  for (const char* how : {"resumed", "extended"}) {
    // final.h5 holds every particle by its number, series.csv all digits; neither has a time stamp
    for (const char* file : {"final.h5", "series.csv"}) {
      const std::string whole = testing::content(directory / "whole" / file);
      EXPECT_FALSE(whole.empty());
      EXPECT_EQ(whole, testing::content(directory / how / file)) << how << ' ' << file;
    }
  }
}

}  // namespace
}  // namespace mpm
