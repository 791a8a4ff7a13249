#include <gtest/gtest.h>
#include <omp.h>

#include "support/solver_states.hpp"

namespace mpm {
namespace {

/// All bytes of all particles in storage order, and what else a state holds, after some steps.
struct Outcome {
  std::vector<Particle> particles;
  std::vector<double> numbers;
};

Outcome run(const Case& c, int threads, int steps) {
  omp_set_num_threads(threads);
  const Scene scene = make_scene(c);
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

// Two threads spin at their barriers, which takes ten times longer where the cores are busy with other tests: fewer steps. Three and four
// sleep.
TEST(Threads, GiveTheSameBitsOfAnAvalancheOnAMast) {
  expect_same_bits(testing::small_avalanche(), 60, {2});
  expect_same_bits(testing::small_avalanche(), 300, {3, 4});
}

TEST(Threads, GiveTheSameBitsWithFlipAndCohesion) {
  Case c = testing::small_avalanche();
  c.material = testing::cam_clay_snow(0.8, 0.3);
  c.numerics.transfer = Transfer::flip;
  expect_same_bits(c, 80, {3});
}

}  // namespace
}  // namespace mpm
