/// The benchmarks' own ground: the reference problem is what it says, and a wrong result does not pass for a right one.
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>

#include "kernels.hpp"
#include "plain_reference.hpp"
#include "reference_problem.hpp"

namespace mpm::benchmarks {
namespace {

constexpr double coarse = 0.2;  // m; 8000 particles in place of 512,000
constexpr double dt = 2e-4;     // s

TEST(ReferenceProblem, HasTheStatedParticlesAndVelocities) {
  const Problem problem = make_reference(coarse, Regime::fully_yielding);
  EXPECT_EQ(problem.state.grid.particle_count(), 8000U);
  problem.state.grid.for_each_particle([](const Particle& p) {
    const double x = p.position[0], z = p.position[2];
    // positions are dx times a fraction, rounded once or twice
    EXPECT_NEAR(p.velocity[0], 5.0 * (x - 1.0) + 2.0 * z, 1e-13);
    EXPECT_EQ(p.velocity[1], 0.0);
    EXPECT_NEAR(p.velocity[2], -5.0 * z, 1e-13);
    EXPECT_EQ(p.affine[0], 5.0);
    EXPECT_EQ(p.affine[6], 2.0);  // dv_x/dz
    EXPECT_EQ(p.affine[8], -5.0);
  });
}

TEST(ReferenceProblem, YieldsAndMovesInEveryCountedStep) {
  SteppedProblem problem = reference_problem(coarse);
  for (int n = 0; n < 20; ++n) {
    int steps = 0;
    const Activity s = problem.counted_step([&](Problem& p, double step_size) {
      step(p.state, p.scene, step_size);
      ++steps;
    });
    EXPECT_GE(s.yielding, 0.99);
    EXPECT_GE(s.changing_cell, 0.02);
    EXPECT_LE(s.changing_block, s.changing_cell);
    EXPECT_GE(steps, 1);
  }
}

TEST(StepTimes, CoverTheStepAndChangeNothing) {
  Problem plain = make_reference(coarse, Regime::fully_yielding), timed = make_reference(coarse, Regime::fully_yielding);
  StepTimes times;
  const auto start = std::chrono::steady_clock::now();
  for (int n = 0; n < 5; ++n) step(timed.state, timed.scene, dt, &times);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (int n = 0; n < 5; ++n) step(plain.state, plain.scene, dt);
  const auto a = copy_particles(plain.state.grid), b = copy_particles(timed.state.grid);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Particle)), 0);
  EXPECT_EQ(plain.state.max_speed, timed.state.max_speed);
  for (const double phase : {times.particle_to_grid, times.grid_update, times.grid_to_particle, times.stress, times.sort})
    EXPECT_GT(phase, 0.0);
  EXPECT_LE(times.total(), wall);
}

TEST(LawPoints, AreInTheirRegime) {
  for (const LawRegime regime : {LawRegime::elastic, LawRegime::yielding, LawRegime::apexes}) {
    Problem problem = make_law_points(1000, regime);
    const auto before = copy_particles(problem.state.grid);
    apply_law(problem.state.grid, problem.scene.material, law_step);
    check_law(problem, before, law_step);
    const auto after = copy_particles(problem.state.grid);
    for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].internal != before[i].internal, regime != LawRegime::elastic);
  }
  Problem inviscid = make_law_points(1000, LawRegime::zero_slope);
  apply_law(inviscid.state.grid, inviscid.scene.material, law_step);
  inviscid.state.grid.for_each_particle([](const Particle& p) { EXPECT_NEAR(p.stress[3], 0.0, 1e-6); });  // q = 0; 1e-10 of p_c
}

/// A change of one particle or node that a check must see.
template <class Check>
void expect_caught(Check&& check) {
  EXPECT_THROW(check(), std::runtime_error);
}

TEST(PlainReference, AcceptsTheLibraryAndCatchesAWrongResult) {
  Problem problem = make_block(1000, 8, true);
  Grid& grid = problem.state.grid;
  const TransferOptions options = transfer_options(problem.scene, dt);
  const auto before = copy_particles(grid);
  const std::int32_t block = grid.occupied_blocks()[0];
  const auto change_first = [&](const auto& change) {
    ParticleBin& bin = grid.block(block).particles;
    Particle p = bin[0];
    change(p);
    bin.set(0, p);
  };
  particle_to_grid(grid, options);
  EXPECT_NO_THROW(check_scatter(grid, options));
  grid.momenta(block).node[63][0] += 1e-9;  // kg m/s; the heaviest node has some 0.04
  expect_caught([&] { check_scatter(grid, options); });

  particle_to_grid(grid, options);
  update_nodes(problem, dt);
  TransferOptions still = options;
  still.dt = 0.0;
  gather(grid, still);
  EXPECT_NO_THROW(check_nodes_and_gather(problem, before, options));
  change_first([](Particle& p) { p.affine[4] += 1e-6; });
  expect_caught([&] { check_nodes_and_gather(problem, before, options); });

  put_back(before, grid);
  apply_law(grid, problem.scene.material, dt);
  EXPECT_NO_THROW(check_law(problem, before, dt));
  change_first([](Particle& p) { p.stress[2] *= 1.0 + 1e-9; });
  expect_caught([&] { check_law(problem, before, dt); });

  put_back(before, grid);
  step(problem.state, problem.scene, dt);
  EXPECT_NO_THROW(check_step(problem, before, dt, 0.0));
  change_first([](Particle& p) { p.position[1] += 1e-9; });
  expect_caught([&] { check_step(problem, before, dt, 0.0); });
  change_first([&](Particle& p) { p.position[1] += grid.cell_size(); });
  expect_caught([&] { check_order(grid, before.size()); });
}

}  // namespace
}  // namespace mpm::benchmarks
