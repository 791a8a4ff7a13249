#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "support/impact_history.hpp"

namespace mpm {
namespace {

using testing::ImpactSample;
using testing::MeasuredImpact;

constexpr double H = 1.75, w = 1.75, dx = 0.25;

ImpactGeometry geometry() { return paper_geometry(H, w, dx, 300.0, false); }
double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

TEST(ForceByHeightOfLayers, KeepsTheForceAndItsFirstMoment) {
  const auto g = geometry();  // 70 bins of 0.125 m
  // 60 layers: up to 14.75 m, beyond the profile's 8.75 m; offsets of the grid shift them against the floor
  for (const double lowest : {-0.5, -0.25, 0.0, 0.1, -0.3}) {
    std::vector<double> force(60);
    double moment = 0.0;
    for (std::size_t k = 0; k < force.size(); ++k) {
      force[k] = 100.0 + 17.0 * std::sin(static_cast<double>(k));
      moment += force[k] * (lowest + dx * static_cast<double>(k));
    }
    const auto by_height = force_by_height(force, lowest, dx, g);
    ASSERT_EQ(by_height.bins.size(), 71u);
    EXPECT_NEAR(sum(by_height.bins), sum(force), 1e-10);
    EXPECT_NEAR(by_height.first_moment, moment, 1e-9);
  }
}

TEST(ForceByHeightOfLayers, SpreadsALayerOverItsCell) {
  const auto g = geometry();
  const auto inner = force_by_height(std::vector<double>{8.0}, 1.0, dx, g);  // represents 0.875 .. 1.125
  EXPECT_NEAR(inner.bins[7], 4.0, 1e-12);
  EXPECT_NEAR(inner.bins[8], 4.0, 1e-12);
  EXPECT_NEAR(sum(inner.bins), 8.0, 1e-12);
  const auto floor = force_by_height(std::vector<double>{8.0}, 0.0, dx, g);  // what is below the floor counts above it
  EXPECT_NEAR(floor.bins[0], 8.0, 1e-12);
  const auto below = force_by_height(std::vector<double>{8.0}, -0.25, dx, g);
  EXPECT_NEAR(below.bins[1] + below.bins[2], 8.0, 1e-12);
  const auto high = force_by_height(std::vector<double>{8.0}, 8.75, dx, g);
  EXPECT_NEAR(high.bins[69], 4.0, 1e-12);
  EXPECT_NEAR(high.bins[70], 4.0, 1e-12);
  EXPECT_EQ(sum(force_by_height({}, 0.0, dx, g).bins), 0.0);
}

const ImpactFlow flow{.velocity = 9.81, .effective_friction = 0.5};  // 2 v/g = 2 s

/// A constant force of 1e5 N after a splash of 2 s, spread evenly over the height up to 3 m.
std::vector<ImpactSample> impact() {
  std::vector<ImpactSample> samples;
  for (int i = 0; i <= 400; ++i) {
    const double force = i == 0 ? std::nan("") : 1e5;
    ImpactSample s;
    s.time = 0.02 * i;
    s.runup = s.runup_p99 = s.time < 2.0 ? 8.0 : 4.0;
    s.impact_pressure = 1e4;
    s.pressure_height = 2.0;
    s.pressure.assign(70, 0.0);
    std::fill_n(s.pressure.begin(), 24, 1e4);
    s.force.x() = force;
    s.force_by_height.assign(71, 0.0);
    std::fill_n(s.force_by_height.begin(), 24, force / 24.0);
    s.first_moment = 1.5 * force;
    samples.push_back(s);
  }
  return samples;
}

TEST(ForceByHeightOfImpacts, GivesForceAboveThePressureHeightAndTheResultantsHeight) {
  const MeasuredImpact m(impact(), geometry(), flow);
  ASSERT_TRUE(m.steady());
  EXPECT_NEAR(m.number("force_above_pressure_height_n"), 1e5 / 3.0, 1e-6) << "2 m of 3 m are below";
  EXPECT_NEAR(m.number("force_resultant_height_m"), 1.5, 1e-12);
  EXPECT_NEAR(m.profile("force_x_per_height_n_m")[0], 1e5 / 3.0, 1e-6);
  EXPECT_EQ(m.profile("force_x_per_height_n_m")[30], 0.0);
  const HeightProfile& over_time = m.profiles.back();
  ASSERT_EQ(over_time.over_time.size(), 401U * 70U) << "without what is above the profile";
  EXPECT_NEAR(over_time.over_time[70 + 23], 1e5 / 3.0, 1e-9);
  EXPECT_EQ(over_time.over_time[70 + 24], 0.0);
}

TEST(ForceByHeightOfImpacts, IsUnknownInFramesButKeepsItsColumn) {
  const ForceByHeight fresh(geometry(), 0U);
  const TimeSeries nothing({});
  const auto profiles = fresh.profiles({.series = nothing});
  ASSERT_EQ(profiles.size(), 1U);
  EXPECT_EQ(profiles[0].column.name(), "force_x_per_height_n_m");
  EXPECT_TRUE(std::isnan(profiles[0].mean.at(69)));
  EXPECT_TRUE(profiles[0].over_time.empty());
}

TEST(PressureProfileOfLowMasts, PressesOnlyBelowTheTop) {
  auto g = geometry();
  g.obstacle.top = 2.0625;  // half of its bin
  const MeasuredImpact m(impact(), g, flow);
  EXPECT_NEAR(m.profile("force_per_height_n_m")[15], 1e4 * w, 1e-8);
  EXPECT_NEAR(m.profile("force_per_height_n_m")[16], 0.5 * 1e4 * w, 1e-8);
  EXPECT_EQ(m.profile("force_per_height_n_m")[17], 0.0);
  EXPECT_NEAR(m.profile("pressure_pa")[17], 1e4, 1e-8);
  EXPECT_NEAR(m.number("profile_force_n"), 1e4 * w * 2.0625, 1e-6);
}

}  // namespace
}  // namespace mpm
