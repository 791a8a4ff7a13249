#include "libmpm/driver/estimate.hpp"

#include <gtest/gtest.h>

#include "libmpm/base/error.hpp"
#include "support/case_texts.hpp"

namespace mpm {
namespace {

using testing::hand_case;
using testing::sheared_case;
using testing::strip_case;
using testing::surge_case;

TEST(Estimate, CountsTheParticlesOfTheScene) {
  const double tolerance = 1e-12;  // relative; a few multiplications
  const Case window = parse_case(strip_case, "case.toml", {"conveyor.feed=window", "conveyor.width_m=10"});
  EXPECT_NEAR(estimate(window).particles / ((10.5 + 4 * 0.25) * 1.75 * 5.0 * 8 * 64), 1.0,
              tolerance);  // half of the window of 7 m and 3.5 m with two cells at either end; 64 cells of 0.25 m in a m^3
  const Case strip = parse_case(strip_case, "case.toml", {"conveyor.width_m=10", "conveyor.velocity_m_s=2"});
  EXPECT_NEAR(estimate(strip).particles / ((2.0 * 6.0 + 3.0) * 1.75 * 5.0 * 8 * 64), 1.0, tolerance);
  const Case hand = parse_case(hand_case, "case.toml");
  EXPECT_NEAR(estimate(hand).particles / ((3.14159265358979324 * 4.0 / 2.0 + 1.0) * 8 * 64), 1.0, tolerance);
}

TEST(Estimate, KnowsTheFastestAndHighestInflow) {
  const auto of = [](const std::string& text, const std::vector<std::string>& sets) {
    return estimate(parse_case(text, "case.toml", sets));
  };
  const Estimate slow = of(surge_case, {}), fast = of(surge_case, {"conveyor.inflow[0].velocity_m_s=40"});
  EXPECT_NEAR(fast.time_step / of(surge_case, {"conveyor.velocity_m_s=40"}).time_step, 1.0, 1e-12);
  EXPECT_LT(fast.time_step, slow.time_step);
  const Estimate high = of(surge_case, {"conveyor.inflow[0].flow_height_m=3.5"});
  EXPECT_NEAR(high.particles / slow.particles, 3.5 / 1.75, 1e-12) << "the conveyor's own height is 1.75 m, the row's 1.5 m";
  // u(H) = v (s + (1 - s)(1 + n)): 2 v for s = 0.5, n = 2, and 1.5 v for n = 1
  const Estimate parabolic = of(sheared_case, {"conveyor.velocity_m_s=3"});
  const Estimate linear = of(sheared_case, {"conveyor.velocity_m_s=4", "conveyor.inflow_shear_exponent=1"});
  EXPECT_NEAR(parabolic.time_step / linear.time_step, 1.0, 1e-12);
}

TEST(Estimate, StepFollowsFromWaveSpeedAndCfl) {
  const Case c = parse_case(strip_case, "case.toml");
  const Estimate e = estimate(c);
  EXPECT_NEAR(e.wave_speed, 58.4, 0.05);  // physics of the paper's snow, as printed there
  EXPECT_LE(e.time_step, c.numerics.cfl * 0.25 / (e.wave_speed + c.conveyor->velocity));
  EXPECT_GE(e.steps * e.time_step, c.output.duration);
}

TEST(Estimate, RefusesWhatDoesNotFit) {
  const Estimate huge = estimate(parse_case(strip_case, "case.toml", {"numerics.cell_size_m=0.0001"}));
  EXPECT_THROW(require_feasible(huge, physical_memory_bytes()), ConfigError);
  EXPECT_NO_THROW(require_feasible(estimate(parse_case(strip_case, "case.toml")), 1e12));
}

}  // namespace
}  // namespace mpm
