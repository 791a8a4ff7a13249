#include "libmpm/observe/contact_force.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/impact_history.hpp"

namespace mpm {
namespace {

const ImpactFlow flow{.velocity = 9.81, .effective_friction = 0.5};  // 2 v/g = 2 s

/// Force that climbs to 3e5 N at 0.5 s, falls to 1e5 N at 1.5 s and stays there; linear between.
double force_at(double t) { return t < 0.5 ? 6e5 * t : t < 1.5 ? 3e5 - 2e5 * (t - 0.5) : 1e5; }

/// Force and moment, as a run records them: means over the intervals before.
struct History {
  std::vector<double> time, force, moment;
};
History history(double duration = 8.0) {
  History h;
  const double interval = 0.02;
  for (int i = 0; i <= std::lround(duration / interval); ++i) {
    h.time.push_back(interval * i);
    h.force.push_back(i == 0 ? std::nan("") : force_at(h.time.back() - 0.5 * interval));
    h.moment.push_back(1.5 * h.force.back());
  }
  return h;
}

ForcePeaks peaks(const History& h, double window) { return force_peaks(h.time, h.force, h.moment, flow, window); }

TEST(TransientForces, AreThoseOfAKnownHistory) {
  const History series = history();
  const auto t = peaks(series, 0.1);
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

TEST(TransientForces, WindowIsTheNumberOfSamplesThatFits) {
  const History series = history();
  for (const double fits : {0.04, 0.06, 0.08, 0.1}) {
    EXPECT_NEAR(peaks(series, fits).window, fits, 1e-12);
    EXPECT_NEAR(peaks(series, fits + 0.019).window, fits, 1e-12);
  }
  const auto raw = peaks(series, 0.001);
  EXPECT_NEAR(raw.window, 0.02, 1e-12);
  EXPECT_EQ(raw.filtered_peak, raw.peak);
}

TEST(TransientForces, OfAFrontAreTheSameWithAnySampling) {
  for (const double interval : {0.02, 0.01, 0.005}) {
    History front;
    for (int i = 0; i <= std::lround(1.0 / interval); ++i) {
      front.time.push_back(interval * i);
      front.force.push_back(i == 0 ? 0.0 : 2e5);
      front.moment.push_back(3e5);
    }
    const auto t = peaks(front, 0.1);
    EXPECT_NEAR(t.window, 0.1, 1e-12);
    EXPECT_NEAR(t.filtered_peak, 2e5, 1e-6);
    EXPECT_NEAR(t.filtered_peak_time, 0.05, 1e-9);
    EXPECT_NEAR(t.rise_time, 0.08, 1e-9) << "the front passes from 10 to 90 % of the window";
  }
}

TEST(TransientForces, OfNothingAreUnknown) {
  EXPECT_TRUE(std::isnan(peaks({}, 0.1).peak));
  History still;
  for (int i = 0; i < 20; ++i) still.time.push_back(0.02 * i);
  still.force = still.moment = std::vector<double>(20, 0.0);
  const auto t = peaks(still, 0.1);
  EXPECT_EQ(t.peak, 0.0);
  EXPECT_TRUE(std::isnan(t.rise_time)) << "nothing rose";
  EXPECT_TRUE(std::isnan(t.peak_time) && std::isnan(t.filtered_peak_time)) << "no peak before the run began";
  EXPECT_EQ(t.first_impact_impulse, 0.0);
  EXPECT_NEAR(t.first_impact_until, 0.38, 1e-12) << "the series ends before the splash is back";
}

TEST(TransientForces, AreResultsOfARun) {
  const History h = history();
  const ImpactGeometry geometry = paper_geometry(1.75, 1.75, 0.25, 300.0, false);
  std::vector<testing::ImpactSample> samples;
  for (std::size_t i = 0; i < h.time.size(); ++i) {
    testing::ImpactSample s;
    s.time = h.time[i];
    s.runup = s.runup_p99 = s.time < 2.0 ? 8.0 : 4.0;
    s.pressure.assign(geometry.profile_bins(), 0.0);
    s.force.x() = h.force[i];
    s.moment.y() = h.moment[i];
    samples.push_back(s);
  }
  const testing::MeasuredImpact m(samples, geometry, flow);
  const ForcePeaks expected = peaks(h, geometry.force_window);
  EXPECT_EQ(m.number("force_peak_n"), expected.peak);
  EXPECT_EQ(m.number("force_rise_time_s"), expected.rise_time);
  EXPECT_EQ(m.number("overturning_moment_peak_n_m"), expected.moment_peak);
  EXPECT_NEAR(m.number("force_peak_to_mean"), (3e5 - 2e3) / 1e5, 1e-9);
}

TEST(ArmLoads, AreThoseOfTheArmAndItsMomentIsAboutTheAxisOfTheMast) {
  const ImpactGeometry geometry = paper_geometry(1.75, 1.75, 0.25, 300.0, false);
  ObserverList observers({std::make_shared<SteadyInterval>(flow, "runup_p99_m"), std::make_shared<Runup>(geometry),
                          std::make_shared<ContactForce>(0U), std::make_shared<ContactForce>(1U, ContactForce::On::arm),
                          std::make_shared<ArmLoads>(flow, 0.1, 0.875)});
  Arrays saved = observers.save();
  constexpr std::size_t samples = 401;
  for (std::size_t i = 0; i < samples; ++i) {
    const double time = 0.02 * static_cast<double>(i);
    for (auto& [name, values] : saved) {
      if (name == "series.time_s") values.push_back(time);
      if (name == "series.runup_m" || name == "series.runup_p99_m") values.push_back(4.0);
      if (name == "series.arm_force_x_n") values.push_back(time > 1.0 && time < 1.5 ? 5e4 : 2e4);
      if (name == "series.arm_force_z_n") values.push_back(1e4);
      if (name == "series.arm_moment_y_n_m") values.push_back(3e4);
      if (name.starts_with("series.") && values.size() == i) values.push_back(0.0);
    }
  }
  observers.load(saved, samples);
  const State state(0.25);
  const RunProgress progress;
  const Results results = observers.results(observers.summary(&state, &progress));
  EXPECT_NEAR(results.number("arm_force_filtered_peak_n"), 5e4, 1e-6);
  EXPECT_NEAR(results.number("arm_force_filtered_peak_time_s"), 1.07, 0.021) << "the first window that is full";
  EXPECT_NEAR(results.number("arm_force_z_filtered_peak_n"), 1e4, 1e-6);
  EXPECT_NEAR(results.number("arm_overturning_moment_mean_n_m"), 3e4 + 0.875 * 1e4, 1e-6);
}

TEST(OverturningMoment, IsShiftedToTheAxisByTheVerticalForce) {
  const std::vector<double> moment{10.0, 20.0}, vertical{3.0, -4.0};
  EXPECT_EQ(overturning_moment(moment, vertical, 0.5), (std::vector<double>{11.5, 18.0}));
  // A force at (0, 0, h) and its moment about the origin: about the axis x = a its arm in x is -a.
  const Vec3 force(5.0, 0.0, 2.0), at(0.0, 0.0, 1.5), axis(0.4, 0.0, 0.0);
  const Vec3 about_origin = at.cross(force), about_axis = (at - axis).cross(force);
  EXPECT_NEAR(overturning_moment(std::vector{about_origin.y()}, std::vector{force.z()}, axis.x())[0], about_axis.y(), 1e-12);
}

}  // namespace
}  // namespace mpm
