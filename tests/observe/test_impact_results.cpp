/// What the observers of an impact make of a whole history: means over the steady interval, peaks, the mean profile.

#include <gtest/gtest.h>

#include <cmath>

#include "libmpm/base/error.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "support/impact_history.hpp"

namespace mpm {
namespace {

using testing::ImpactSample;
using testing::MeasuredImpact;

constexpr double H = 1.75, w = 1.75;

ImpactGeometry geometry() { return paper_geometry(H, w, 0.25, 300.0, false); }

/// A splash of 2 s, then a steady state with a ripple of ten periods of 0.64 s each: what the means must give is known.
std::vector<ImpactSample> splash(double duration = 8.4) {
  std::vector<ImpactSample> samples;
  for (int i = 0; i <= std::lround(duration / 0.02); ++i) {
    const double t = 0.02 * i, ripple = std::sin(2.0 * 3.14159265358979323846 * t / 0.64);
    const double higher = t < 2.0 ? 5.0 : 0.0;
    ImpactSample s;
    s.time = t;
    s.runup = 4.0 + 0.1 * ripple + higher;
    s.runup_p99 = 3.5 + 0.1 * ripple + higher;
    s.impact_pressure = 2e4 * (1.0 + 0.05 * ripple);
    s.pressure_height = i % 7 == 0 ? std::nan("") : 2.5;
    s.compaction = 1.1;
    s.pressure.assign(70, 0.0);
    std::fill_n(s.pressure.begin(), 24, s.impact_pressure);  // uniform up to 3 m
    s.force = Vec3(1e5, 0.0, 3e3) * (1.0 + 0.05 * ripple);
    s.moment = Vec3(0.0, 1.5e5, 0.0);
    samples.push_back(s);
  }
  return samples;
}

const ImpactFlow flow{.velocity = 9.81, .effective_friction = 0.5};  // 2 v/g = 2 s

TEST(ImpactResults, AreMeansOverTheSteadyIntervalAndPeaksOverAll) {
  const MeasuredImpact m(splash(), geometry(), flow);
  ASSERT_TRUE(m.steady());
  EXPECT_GE(m.number("steady_from_s"), 2.0);
  EXPECT_NEAR(m.number("steady_to_s"), 8.4, 1e-12);
  // The interval is ten periods long give or take a few samples: the ripple's mean is below amplitude / (2 pi * 10 periods) * 2.
  const double ripple = 2.0 / (2.0 * 3.14 * 9.0);
  EXPECT_NEAR(m.number("runup_mean_m"), 4.0, 0.1 * ripple);
  EXPECT_NEAR(m.number("runup_p99_mean_m"), 3.5, 0.1 * ripple);
  EXPECT_NEAR(m.number("impact_pressure_mean_pa"), 2e4, 1e3 * ripple);
  EXPECT_NEAR(m.number("force_mean_n", 0), 1e5, 5e3 * ripple);
  EXPECT_EQ(m.number("force_mean_n", 1), 0.0);
  EXPECT_NEAR(m.number("moment_mean_n_m", 1), 1.5e5, 1e-9);
  EXPECT_NEAR(m.number("compaction_mean"), 1.1, 1e-12);
  EXPECT_EQ(m.number("pressure_height_mean_m"), 2.5) << "undefined instants are left out";
  EXPECT_NEAR(m.number("runup_peak_m"), 9.1, 1e-3);  // the ripple is sampled 32 times a period
  EXPECT_NEAR(m.number("runup_p99_peak_m"), 8.6, 1e-3);
  EXPECT_NEAR(m.number("runup_peak_to_mean"), 9.1 / 4.0, 0.1 * ripple);
  EXPECT_EQ(m.number("pressure_height_peak_m"), 2.5);
  EXPECT_EQ(m.number("predicted_runup_m"), predicted_runup(0.5, 9.81, H));
  EXPECT_EQ(m.number("predicted_pressure_height_m"), predicted_pressure_height(0.5, 9.81, H));
}

TEST(ImpactResults, DoNotDependOnOneStrayParticle) {
  // A particle on top of the jet that flies up and falls back for seconds: the highest particle is never steady.
  auto samples = splash();
  const MeasuredImpact without(samples, geometry(), flow);
  for (ImpactSample& s : samples) s.runup += s.time > 2.0 ? 0.9 * (s.time - 2.0) : 0.0;
  const MeasuredImpact with(samples, geometry(), flow);
  ASSERT_TRUE(with.steady());
  for (const char* key : {"steady_from_s", "steady_to_s", "runup_p99_mean_m", "pressure_height_mean_m", "runup_p99_peak_m"})
    EXPECT_EQ(with.number(key), without.number(key)) << key;
  EXPECT_EQ(with.number("force_mean_n", 0), without.number("force_mean_n", 0));
  EXPECT_GT(with.number("runup_mean_m"), without.number("runup_mean_m") + 1.0) << "the paper's run-up is that of the particle";
}

TEST(ImpactResults, HaveAStandardErrorForEveryMean) {
  const MeasuredImpact m(splash(), geometry(), flow);
  const auto series = m.observers.series()["runup_m"];
  const auto first = static_cast<std::size_t>(std::lround(m.number("steady_from_s") / 0.02));
  const MeanEstimate expected = estimate_mean(series.subspan(first));
  EXPECT_EQ(m.number("runup_mean_m"), expected.mean);
  EXPECT_EQ(m.number("runup_standard_error_m"), expected.standard_error);
  EXPECT_EQ(m.number("runup_effective_samples"), expected.effective_samples);
  for (const Column& column : m.observers.series().columns()) {
    for (const auto& key : {column.statistic("mean"), column.statistic("standard_error"), column.statistic("effective_samples", false)})
      EXPECT_EQ(m.results.has(key), column.mean) << key;
  }
  EXPECT_EQ(m.results.find("runup_mean_m")->nature, Nature::physics);
  EXPECT_EQ(m.results.find("runup_standard_error_m")->nature, Nature::uncertainty);
  EXPECT_EQ(m.results.find("runup_effective_samples")->nature, Nature::uncertainty);
}

TEST(ImpactResults, ForceOfAUniformProfileIsPressureTimesArea) {
  const MeasuredImpact m(splash(), geometry(), flow);
  EXPECT_NEAR(m.number("profile_force_n") / (m.number("impact_pressure_mean_pa") * w * 3.0), 1.0, 1e-12);
  ASSERT_EQ(m.profile("z_m").size(), 70U);
  EXPECT_DOUBLE_EQ(m.profile("z_m")[0], 0.0625);
  EXPECT_NEAR(m.profile("force_per_height_n_m")[0], m.number("impact_pressure_mean_pa") * w, 1e-8);
  EXPECT_NEAR(m.profile("smoothed_pressure_pa")[5], m.profile("pressure_pa")[5], 1e-8) << "uniform around here";
  EXPECT_EQ(m.profile("pressure_pa")[30], 0.0);
  // The bias of the filter depends on the step's place among the bins, not on its height: 1.2092 H - H as for a step at H
  // (test_measure.cpp).
  EXPECT_NEAR(m.number("pressure_height_of_mean_profile_m"), 3.0 + 0.2091517857142855 * H, 1e-11);
}

TEST(ImpactResults, MeanProfileIsTheMeanOfTheInstantsPressures) {
  auto samples = splash();
  for (std::size_t i = 0; i < samples.size(); ++i)
    std::fill_n(samples[i].pressure.begin(), 24, i % 2 == 0 ? 600.0 : 0.0);  // half are empty
  const MeasuredImpact m(samples, geometry(), flow);
  ASSERT_TRUE(m.steady());
  const double n = m.number("steady_samples");
  EXPECT_NEAR(m.profile("pressure_pa")[10], 300.0, 300.0 / n);
}

TEST(ImpactResults, AreUnknownWithoutASteadyInterval) {
  const MeasuredImpact m(splash(1.9), geometry(), flow);
  EXPECT_FALSE(m.steady());
  for (const char* key : {"steady_from_s", "runup_mean_m", "force_mean_n", "profile_force_n", "force_resultant_height_m"})
    EXPECT_TRUE(std::isnan(m.number(key))) << key;
  EXPECT_TRUE(m.profile("pressure_pa").empty());
  EXPECT_NEAR(m.number("runup_peak_m"), 9.1, 1e-3) << "the peak exists all the same";
}

TEST(ImpactResults, OfNothingAreTheSameEntriesAllUnknown) {
  const MeasuredImpact nothing({}, geometry(), {}), something(splash(), geometry(), flow);
  EXPECT_FALSE(nothing.steady());
  EXPECT_TRUE(std::isnan(nothing.number("runup_peak_m")));
  EXPECT_TRUE(std::isnan(nothing.number("predicted_runup_m"))) << "a law without M'";
  ASSERT_EQ(nothing.results.entries().size(), something.results.entries().size());
  for (std::size_t i = 0; i < nothing.results.entries().size(); ++i)
    EXPECT_EQ(nothing.results.entries()[i].name, something.results.entries()[i].name);
}

}  // namespace
}  // namespace mpm
