#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "mpm/error.hpp"
#include "mpm/impact/results.hpp"

namespace mpm {
namespace {

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
  const auto inner = force_by_height(std::vector<double>{8.0}, 1.0, dx, g);  // stands for 0.875 .. 1.125
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

/// Force that climbs to 3e5 N at 0.5 s, falls to 1e5 N at 1.5 s and stays there; linear between.
double force_at(double t) { return t < 0.5 ? 6e5 * t : t < 1.5 ? 3e5 - 2e5 * (t - 0.5) : 1e5; }

ImpactSeries series_of_an_impact(bool booked, double duration = 8.0) {
  ImpactSeries series;
  const double interval = 0.02;
  for (int i = 0; i <= static_cast<int>(duration / interval + 0.5); ++i) {
    const double t = interval * i, force = i == 0 ? std::nan("") : force_at(t - 0.5 * interval);
    ImpactFrame frame;
    frame.runup = t < 2.0 ? 8.0 : 4.0;
    frame.pressure.assign(70, 0.0);
    std::fill_n(frame.pressure.begin(), 24, 1e4);
    frame.impact_pressure = 1e4;
    frame.pressure_height = 2.0;
    std::optional<ForceByHeight> by_height;
    if (booked) {
      by_height.emplace(ForceByHeight{std::vector<double>(71, 0.0), force * 1.5});
      std::fill_n(by_height->bins.begin(), 24, force / 24.0);  // uniform up to 3 m
    }
    series.append(t, frame, Vec3(force, 0.0, 0.0), Vec3(0.0, 1.5 * force, 0.0), by_height);
  }
  return series;
}

TEST(TransientForces, AreThoseOfAKnownHistory) {
  const auto series = series_of_an_impact(false);
  const auto t = transient_force(series, flow, 0.1);
  EXPECT_NEAR(t.interval, 0.02, 1e-12);
  EXPECT_NEAR(t.window, 0.1, 1e-12);
  EXPECT_NEAR(t.peak, 3e5 - 0.01 * 2e5, 1e-6) << "the interval after the kink, 0.01 s past it";
  EXPECT_NEAR(t.peak_time, 0.51, 1e-9);
  // around the kink: the best of the five-sample windows
  double best = 0.0;
  for (int middle = 2; middle < 100; ++middle) {
    double mean = 0.0;
    for (int i = -2; i <= 2; ++i) mean += force_at(0.02 * (middle + i) + 0.01) / 5.0;
    best = std::max(best, mean);
  }
  EXPECT_NEAR(t.filtered_peak, best, 1e-6);
  EXPECT_LT(t.filtered_peak, t.peak);
  EXPECT_NEAR(t.filtered_peak_time, 0.51, 0.021);
  // A straight flank keeps its slope under the mean; 10 % are passed while the window still reaches back to before the kink at t = 0.
  EXPECT_NEAR(t.rise_time, 0.8 * best / 6e5, 5e-4);
  EXPECT_NEAR(t.first_impact_until, 2.0, 1e-12);
  // 0.5 x 0.5 x 3e5 + 1 x 2e5 + 0.5 x 1e5, by the midpoint rule: exact but where a kink is inside an interval (it is not)
  EXPECT_NEAR(t.first_impact_impulse, 0.75e5 + 2e5 + 0.5e5, 1e-6);
  EXPECT_NEAR(t.moment_peak, 1.5 * t.peak, 1e-6);
  EXPECT_EQ(t.moment_peak_time, t.peak_time);
  EXPECT_NEAR(t.moment_filtered_peak, 1.5 * best, 1e-6);
}

TEST(TransientForces, WindowIsTheNearestOddNumberOfSamplesBelow) {
  const auto series = series_of_an_impact(false);
  EXPECT_NEAR(transient_force(series, flow, 0.06).window, 0.06, 1e-12);
  EXPECT_NEAR(transient_force(series, flow, 0.07).window, 0.06, 1e-12);
  const auto raw = transient_force(series, flow, 0.001);
  EXPECT_NEAR(raw.window, 0.02, 1e-12);
  EXPECT_EQ(raw.filtered_peak, raw.peak);
}

TEST(TransientForces, OfNothingAreUnknown) {
  EXPECT_TRUE(std::isnan(transient_force({}, flow, 0.1).peak));
  ImpactSeries still;
  for (int i = 0; i < 20; ++i) {
    ImpactFrame frame;
    still.append(0.02 * i, frame, Vec3::Zero(), Vec3::Zero());
  }
  const auto t = transient_force(still, flow, 0.1);
  EXPECT_EQ(t.peak, 0.0);
  EXPECT_TRUE(std::isnan(t.rise_time)) << "nothing rose";
  EXPECT_EQ(t.first_impact_impulse, 0.0);
  EXPECT_NEAR(t.first_impact_until, 0.38, 1e-12) << "the series ends before the splash is back";
}

TEST(ImpactSummaryOfBookedForces, GivesForceAboveThePressureHeightAndTheResultantsHeight) {
  const auto series = series_of_an_impact(true);
  const auto s = summarise(series, geometry(), flow);
  ASSERT_TRUE(s.span.steady);
  EXPECT_NEAR(s.force_above_pressure_height, 1e5 / 3.0, 1e-6) << "2 m of 3 m are below";
  EXPECT_NEAR(s.force_resultant_height, 1.5, 1e-12);
  const auto rows = mean_profile(series, s.span, geometry());
  EXPECT_NEAR(rows[0].force_x_per_height, 1e5 / 3.0, 1e-6);
  EXPECT_EQ(rows[30].force_x_per_height, 0.0);
  const auto json = nlohmann::json::parse(to_json(s));
  for (const char* key :
       {"force_above_pressure_height_n", "force_resultant_height_m", "force_interval_s", "force_window_s", "force_peak_n",
        "force_peak_time_s", "force_peak_to_mean", "force_filtered_peak_n", "force_filtered_peak_time_s", "force_filtered_peak_to_mean",
        "force_rise_time_s", "first_impact_until_s", "first_impact_impulse_n_s", "overturning_moment_peak_n_m",
        "overturning_moment_peak_time_s", "overturning_moment_filtered_peak_n_m", "runup_peak_to_mean"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_TRUE(json.at(key).is_number()) << key;
  }
  EXPECT_NEAR(json.at("force_peak_to_mean").get<double>(), (3e5 - 2e3) / 1e5, 1e-9);
  EXPECT_NEAR(json.at("runup_peak_to_mean").get<double>(), 2.0, 1e-12);
}

TEST(ImpactSummaryOfBookedForces, SaysNothingOfHeightsThatWereNotBooked) {
  const auto series = series_of_an_impact(false);
  const auto s = summarise(series, geometry(), flow);
  const auto json = nlohmann::json::parse(to_json(s));
  EXPECT_FALSE(json.contains("force_above_pressure_height_n"));
  EXPECT_TRUE(std::isnan(mean_profile(series, s.span, geometry())[0].force_x_per_height));
  auto mixed = series_of_an_impact(true);
  EXPECT_THROW(mixed.append(
                   9.0,
                   [] {
                     ImpactFrame frame;
                     frame.pressure.assign(70, 0.0);
                     return frame;
                   }(),
                   Vec3::Zero(), Vec3::Zero()),
               ConfigError);
}

TEST(ImpactSummaryOfLowMasts, PressureProfilePressesOnlyBelowTheTop) {
  auto g = geometry();
  g.obstacle_height = 2.0625;  // half of its bin
  const auto series = series_of_an_impact(false);
  const auto s = summarise(series, g, flow);
  const auto rows = mean_profile(series, s.span, g);
  EXPECT_NEAR(rows[15].force_per_height, 1e4 * w, 1e-8);
  EXPECT_NEAR(rows[16].force_per_height, 0.5 * 1e4 * w, 1e-8);
  EXPECT_EQ(rows[17].force_per_height, 0.0);
  EXPECT_NEAR(rows[17].pressure, 1e4, 1e-8);
  EXPECT_NEAR(s.profile_force, 1e4 * w * 2.0625, 1e-6);
}

}  // namespace
}  // namespace mpm
