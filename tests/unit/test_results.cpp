#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mpm/error.hpp"
#include "mpm/impact/results.hpp"
#include "mpm/impact/semi_empirical.hpp"

namespace mpm {
namespace {

constexpr double H = 1.75, w = 1.75;

ImpactGeometry geometry() { return paper_geometry(H, w, 0.25, 300.0, false); }

/// A splash of 2 s, then a steady state with a ripple of ten periods of 0.64 s each: what the means must give is known.
ImpactSeries series_with_splash(double duration = 8.4) {
  ImpactSeries series;
  for (int i = 0; i <= static_cast<int>(duration / 0.02 + 0.5); ++i) {
    const double t = 0.02 * i, ripple = std::sin(2.0 * 3.14159265358979323846 * t / 0.64);
    const double splash = t < 2.0 ? 5.0 : 0.0;
    ImpactFrame frame;
    frame.runup = 4.0 + 0.1 * ripple + splash;
    frame.runup_p99 = 3.5 + 0.1 * ripple + splash;
    frame.impact_pressure = 2e4 * (1.0 + 0.05 * ripple);
    frame.pressure_height = i % 7 == 0 ? std::nullopt : std::optional(2.5);
    frame.compaction = 1.1;
    frame.pressure.assign(70, 0.0);
    std::fill_n(frame.pressure.begin(), 24, frame.impact_pressure);  // uniform up to 3 m
    series.append(t, frame, Vec3(1e5, 0.0, 3e3) * (1.0 + 0.05 * ripple), Vec3(0.0, 1.5e5, 0.0));
  }
  return series;
}

const ImpactFlow flow{.velocity = 9.81, .effective_friction = 0.5};  // 2 v/g = 2 s

TEST(ImpactSummary, TakesMeansOverTheSteadySpanAndPeaksOverAll) {
  const auto s = summarise(series_with_splash(), geometry(), flow);
  ASSERT_TRUE(s.span.steady);
  EXPECT_GE(s.span.from, 2.0);
  EXPECT_NEAR(s.span.to, 8.4, 1e-12);
  // The span is ten periods long give or take a few samples: the ripple's mean is below amplitude / (2 pi * 10 periods) * 2.
  const double ripple = 2.0 / (2.0 * 3.14 * 9.0);
  EXPECT_NEAR(s.runup.mean, 4.0, 0.1 * ripple);
  EXPECT_NEAR(s.runup_p99.mean, 3.5, 0.1 * ripple);
  EXPECT_NEAR(s.impact_pressure.mean, 2e4, 1e3 * ripple);
  EXPECT_NEAR(s.force[0].mean, 1e5, 5e3 * ripple);
  EXPECT_EQ(s.force[1].mean, 0.0);
  EXPECT_NEAR(s.moment[1].mean, 1.5e5, 1e-9);
  EXPECT_NEAR(s.compaction.mean, 1.1, 1e-12);
  EXPECT_EQ(s.pressure_height.mean, 2.5) << "undefined instants are left out";
  EXPECT_LT(s.pressure_height.samples, s.runup.samples);
  EXPECT_NEAR(s.runup_peak, 9.1, 1e-3);  // the ripple is sampled 32 times a period
  EXPECT_EQ(s.pressure_height_peak, 2.5);
  EXPECT_EQ(s.predicted_runup, predicted_runup(0.5, 9.81, H));
  EXPECT_EQ(s.predicted_pressure_height, predicted_pressure_height(0.5, 9.81, H));
}

TEST(ImpactSummary, ForceOfAUniformProfileIsPressureTimesArea) {
  const auto series = series_with_splash();
  const auto s = summarise(series, geometry(), flow);
  EXPECT_NEAR(s.profile_force / (s.impact_pressure.mean * w * 3.0), 1.0, 1e-12);
  const auto rows = mean_profile(series, s.span, geometry());
  ASSERT_EQ(rows.size(), 70u);
  EXPECT_DOUBLE_EQ(rows[0].z, 0.0625);
  EXPECT_NEAR(rows[0].force_per_height, s.impact_pressure.mean * w, 1e-8);
  EXPECT_NEAR(rows[5].smoothed, rows[5].pressure, 1e-8) << "uniform around here";
  EXPECT_EQ(rows[30].pressure, 0.0);
  // The bias of the filter depends on the step's place among the bins, not on its height: 1.2092 H - H as for a step at H
  // (test_measure.cpp).
  EXPECT_NEAR(s.pressure_height_of_mean_profile, 3.0 + 0.2091517857142855 * H, 1e-11);
}

TEST(ImpactSummary, MeanProfileIsTheMeanOfTheInstantsPressures) {
  ImpactSeries series;
  for (int i = 0; i < 3; ++i) {
    ImpactFrame frame;
    frame.pressure.assign(70, i == 2 ? 0.0 : 300.0 * (i + 1));  // 300, 600, empty
    series.append(i, frame, Vec3::Zero(), Vec3::Zero());
  }
  const Steady span{.steady = true, .from = 0.0, .to = 2.0, .first = 0, .last = 3};
  EXPECT_DOUBLE_EQ(mean_profile(series, span, geometry())[10].pressure, 300.0);
  EXPECT_TRUE(mean_profile(series, Steady{}, geometry()).empty());
}

TEST(ImpactSummary, GivesNoMeansWithoutASteadySpan) {
  const auto s = summarise(series_with_splash(1.9), geometry(), flow);
  EXPECT_FALSE(s.span.steady);
  EXPECT_TRUE(std::isnan(s.runup.mean));
  EXPECT_TRUE(std::isnan(s.force[0].mean));
  EXPECT_TRUE(std::isnan(s.profile_force));
  EXPECT_NEAR(s.runup_peak, 9.1, 1e-3) << "the peak exists all the same";
  const auto json = nlohmann::json::parse(to_json(s));
  EXPECT_EQ(json.at("steady"), false);
  EXPECT_TRUE(json.at("runup_mean_m").is_null());
  EXPECT_TRUE(json.at("steady_from_s").is_null());
  EXPECT_TRUE(json.at("force_mean_n").at(2).is_null());
  const auto empty = summarise({}, geometry(), {});
  EXPECT_FALSE(empty.span.steady);
  EXPECT_TRUE(std::isnan(empty.runup_peak));
  EXPECT_TRUE(std::isnan(empty.predicted_runup)) << "a law without M'";
}

TEST(ImpactSummary, WritesEveryKeyOfResultsJson) {
  const auto s = summarise(series_with_splash(), geometry(), flow);
  const auto json = nlohmann::json::parse(to_json(s));
  for (const char* key : {"steady", "steady_from_s", "steady_to_s", "runup_mean_m", "runup_p99_mean_m", "runup_standard_error_m",
                          "runup_peak_m", "pressure_height_mean_m", "impact_pressure_mean_pa", "force_mean_n", "moment_mean_n_m",
                          "compaction_mean", "predicted_runup_m", "predicted_pressure_height_m"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json.at("runup_mean_m").get<double>(), s.runup.mean) << "to the bit";
  EXPECT_EQ(json.at("force_mean_n").size(), 3u);
  EXPECT_EQ(json.at("force_mean_n").at(0).get<double>(), s.force[0].mean);
  EXPECT_EQ(json.at("compaction_standard_error").get<double>(), s.compaction.standard_error);
}

TEST(ImpactSeries, RefusesColumnsThatDoNotBelongTogether) {
  auto series = series_with_splash();
  ImpactFrame frame;
  frame.pressure.assign(69, 0.0);
  EXPECT_THROW(series.append(9.0, frame, Vec3::Zero(), Vec3::Zero()), ConfigError);
  series.runup.pop_back();
  EXPECT_THROW((void)summarise(series, geometry(), flow), ConfigError);
}

}  // namespace
}  // namespace mpm
