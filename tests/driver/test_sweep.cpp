#include "libmpm/driver/sweep.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "libmpm/base/error.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// A short fall of a small block: no impact, some hundred particle-steps a size.
Case falling_block() {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body(Vec3(0.0, 0.0, 0.0), Vec3(1.0, 1.0, 1.0))};
  c.domain = {.min = Vec3::Constant(-5.0), .max = Vec3::Constant(5.0)};
  c.output.duration = 0.02;
  c.output.series_per_second = 100.0;
  c.output.frames_per_second = 0.0;
  return c;
}

TEST(SweepOrder, IsCoarseFirstAndRefusesDoubles) {
  EXPECT_EQ(in_order({SweepKind::cell_size, {0.2, 0.5, 0.3}, {}}).values, (std::vector{0.5, 0.3, 0.2}));
  EXPECT_EQ(in_order({SweepKind::particles_per_cell, {27, 1, 8}, {}}).values, (std::vector{1.0, 8.0, 27.0}));
  EXPECT_EQ(in_order({SweepKind::offset, {0.5, 0.0}, "x"}).values, (std::vector{0.5, 0.0}));
  EXPECT_THROW((void)in_order({SweepKind::cell_size, {0.2, 0.2}, {}}), ConfigError);
  EXPECT_THROW((void)in_order({SweepKind::cell_size, {}, {}}), ConfigError);
  EXPECT_THROW((void)in_order({SweepKind::offset, {0.5}, "w"}), ConfigError);
  EXPECT_THROW((void)in_order({SweepKind::offset, {0.5}, "xx"}), ConfigError);
}

TEST(SweptCase, ChangesOneKeyAndPassesTheChecksOfACaseFile) {
  const Case c = testing::small_avalanche();
  Case expected = c;
  expected.numerics.cell_size = 0.125;
  EXPECT_EQ(swept_case(c, {SweepKind::cell_size, {}, {}}, 0.125), expected);
  expected = c;
  expected.numerics.cfl = 0.8;
  EXPECT_EQ(swept_case(c, {SweepKind::cfl, {}, {}}, 0.8), expected);
  expected = c;
  expected.numerics.particles_per_cell = 27;
  EXPECT_EQ(swept_case(c, {SweepKind::particles_per_cell, {}, {}}, 27.0), expected);
  expected = c;
  expected.numerics.grid_offset = {0.25, 0.0, 0.25};  // the mirror plane y = 0 stays on the grid
  EXPECT_EQ(swept_case(c, {SweepKind::offset, {}, {}}, 0.25), expected);
  expected.numerics.grid_offset = {0.0, 0.0, 0.25};
  EXPECT_EQ(swept_case(c, {SweepKind::offset, {}, "z"}, 0.25), expected);
  EXPECT_THROW((void)swept_case(c, {SweepKind::offset, {}, "y"}, 0.25), ConfigError);
  EXPECT_THROW((void)swept_case(c, {SweepKind::particles_per_cell, {}, {}}, 9.0), ConfigError);
  EXPECT_THROW((void)swept_case(c, {SweepKind::particles_per_cell, {}, {}}, 8.5), ConfigError);
  EXPECT_THROW((void)swept_case(c, {SweepKind::cell_size, {}, {}}, 5.0), ConfigError);
}

TEST(RunSweep, RunsEachValueOnceAndTakesUpWhatIsFinished) {
  const testing::TemporaryDirectory directory;
  SweepOptions options;
  options.out = directory.path();
  options.run.threads = 1;
  const Sweep sweep{SweepKind::cell_size, {0.25, 0.5}, {}};
  const SweepResult first = run_sweep(falling_block(), sweep, options);
  ASSERT_TRUE(first.finished);
  ASSERT_EQ(first.points.size(), 2u);
  EXPECT_EQ(first.points[0].directory, directory / "dx_0.5");
  EXPECT_FALSE(first.points[0].reused);
  EXPECT_EQ(first.points[0].results.number("particles_final"), 64.0);
  EXPECT_EQ(first.points[1].results.number("particles_final"), 512.0);

  options.run.resume = true;
  const SweepResult again = run_sweep(falling_block(), {SweepKind::cell_size, {0.5, 0.25, 0.2}, {}}, options);
  ASSERT_EQ(again.points.size(), 3u);
  EXPECT_TRUE(again.points[0].reused);
  EXPECT_TRUE(again.points[1].reused);
  EXPECT_FALSE(again.points[2].reused);
  EXPECT_EQ(again.points[0].results.to_json(), first.points[0].results.to_json());

  Case longer = falling_block();
  longer.output.duration = 0.03;
  // over another duration: nothing is replaced unasked, nor removed before that is certain
  EXPECT_THROW((void)run_sweep(longer, sweep, options), ConfigError);
  options.run.resume = false;
  EXPECT_THROW((void)run_sweep(longer, sweep, options), ConfigError);
  EXPECT_THROW((void)run_sweep(falling_block(), sweep, options), ConfigError);
  EXPECT_EQ(read_file(directory / "dx_0.5/results.json"), first.points[0].results.to_json());
  EXPECT_TRUE(std::filesystem::exists(directory / "dx_0.5/final.h5"));
  options.overwrite = true;
  EXPECT_FALSE(run_sweep(longer, sweep, options).points[0].reused);
}

TEST(RunSweep, StopsOnRequestAndGoesOn) {
  const testing::TemporaryDirectory directory;
  SweepOptions options;
  options.out = directory.path();
  options.run.threads = 1;
  int samples = 0;
  options.run.poll = [&] { return ++samples == 3 ? Request::stop : Request::none; };  // inside the second run
  const Sweep sweep{SweepKind::cfl, {0.4, 0.2}, {}};
  const SweepResult stopped = run_sweep(falling_block(), sweep, options);
  EXPECT_FALSE(stopped.finished);
  EXPECT_EQ(stopped.points.size(), 1u);
  options.run.poll = {};
  options.run.resume = true;
  const SweepResult done = run_sweep(falling_block(), sweep, options);
  EXPECT_TRUE(done.finished);
  EXPECT_TRUE(done.points[0].reused);
  EXPECT_FALSE(done.points[1].reused);
}

}  // namespace
}  // namespace mpm
