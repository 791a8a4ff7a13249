#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/impact/steady.hpp"

namespace mpm {
namespace {

std::vector<double> times(std::size_t n, double dt) {
  std::vector<double> t(n);
  for (std::size_t i = 0; i < n; ++i) t[i] = dt * static_cast<double>(i);
  return t;
}

/// First-order autoregression x_k+1 = phi x_k + e_k, e_k standard normal, started from its stationary distribution.
std::vector<double> autoregression(std::size_t n, double phi, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<double> x(n);
  x[0] = normal(random) / std::sqrt(1.0 - phi * phi);
  for (std::size_t i = 1; i < n; ++i) x[i] = phi * x[i - 1] + normal(random);
  return x;
}

TEST(SteadySpan, OfAConstantStartsAsSoonAsItMay) {
  const auto t = times(301, 0.02);
  const std::vector<double> value(301, 2.5);
  SteadyCriteria criteria;
  criteria.earliest = 1.99;
  const Steady s = find_steady(t, value, criteria);
  ASSERT_TRUE(s.steady);
  EXPECT_EQ(s.first, 100u);
  EXPECT_EQ(s.last, 301u);
  EXPECT_EQ(s.from, t[100]);
  EXPECT_EQ(s.to, t[300]);
}

TEST(SteadySpan, LeavesOutADecayingSplash) {
  // 1 + 4 exp(-t): the running mean of a span of length T from s is 1 + 4 exp(-s) (1 - exp(-T))/T; it is judged from a tenth of the span
  // on.
  const auto t = times(1001, 0.01);
  std::vector<double> value(1001);
  for (std::size_t i = 0; i <= 1000; ++i) value[i] = 1.0 + 4.0 * std::exp(-t[i]);
  const Steady s = find_steady(t, value, {.minimum_duration = 2.0});
  ASSERT_TRUE(s.steady);
  const auto excess = [&](double from, double length) { return 4.0 * std::exp(-from) * (1.0 - std::exp(-length)) / length; };
  const auto deviation = [&](double from) {
    return (excess(from, 0.1 * (10.0 - from)) - excess(from, 10.0 - from)) / (1.0 + excess(from, 10.0 - from));
  };
  // Sums replace integrals: one sample in a tenth of the span, about 60, shifts the mean of a decay by less than 1 %.
  EXPECT_NEAR(deviation(s.from), 0.05, 0.0005 + 0.01 * 0.05);
}

TEST(SteadySpan, IsTheLongestThatQualifies) {
  // The definition in its plainest form, without running sums.
  std::mt19937_64 random(3);
  const auto t = times(200, 0.02);
  for (int trial = 0; trial < 20; ++trial) {
    auto value = autoregression(200, 0.9, random);
    for (std::size_t i = 0; i < 200; ++i) value[i] = 5.0 + 0.3 * value[i] + 4.0 * std::exp(-2.0 * t[i]);
    const SteadyCriteria criteria{.minimum_duration = 1.0};
    const auto qualifies = [&](std::size_t first) {
      const auto mean = [&](std::size_t last) {
        double sum = 0.0;
        for (std::size_t i = first; i < last; ++i) sum += value[i];
        return sum / static_cast<double>(last - first);
      };
      for (std::size_t last = first + 1; last <= 200; ++last) {
        const bool judged = static_cast<double>(last - first) >= 0.1 * static_cast<double>(200 - first);
        if (judged && std::abs(mean(last) - mean(200)) > 0.05 * mean(200)) return false;
      }
      return t[199] - t[first] >= 1.0;
    };
    std::size_t expected = 0;
    while (expected < 200 && !qualifies(expected)) ++expected;
    const Steady s = find_steady(t, value, criteria);
    EXPECT_EQ(s.steady, expected < 200);
    if (s.steady) {
      EXPECT_EQ(s.first, expected);
    }
  }
}

TEST(SteadySpan, DoesNotExistForAGrowingSeries) {
  const auto t = times(500, 0.02);
  std::vector<double> value(500);
  for (std::size_t i = 0; i < 500; ++i) value[i] = t[i];
  const auto criteria = impact_steady_criteria({.velocity = 4.0, .gravity = 9.81}, t.back());
  const Steady s = find_steady(t, value, criteria);
  EXPECT_FALSE(s.steady);
  EXPECT_EQ(s.last, 0u);
}

TEST(SteadySpan, IsNotMadeOfTheLastFewSamples) {
  // Without a shortest duration the last samples of anything smooth agree.
  const auto t = times(500, 0.02);
  std::vector<double> value(500);
  for (std::size_t i = 0; i < 500; ++i) value[i] = std::exp(0.3 * t[i]);
  EXPECT_TRUE(find_steady(t, value, {}).steady);
  EXPECT_FALSE(find_steady(t, value, {.minimum_duration = 2.0}).steady);
}

TEST(SteadySpan, DoesNotDependOnUnitOrOriginOfTime) {
  std::mt19937_64 random(5);
  auto value = autoregression(400, 0.8, random);
  auto t = times(400, 0.015625);  // a power of two: shifts are exact
  for (std::size_t i = 0; i < 400; ++i) value[i] = 8.0 + value[i] + 20.0 * std::exp(-t[i]);
  const Steady a = find_steady(t, value, {.earliest = 0.5, .minimum_duration = 1.0});
  for (double& v : value) v *= 1024.0;
  for (double& time : t) time += 16.0;
  const Steady b = find_steady(t, value, {.earliest = 16.5, .minimum_duration = 1.0});
  EXPECT_EQ(a.steady, b.steady);
  EXPECT_EQ(a.first, b.first);
}

TEST(SteadySpan, OfStationaryNoiseIsMostOfTheSeries) {
  // Noise of 10 % of the mean with a correlation time of 19 samples: the mean of a tenth of 1000 samples has a standard error of 4 %.
  // Spans that start in a calm stretch qualify: on average over the trials more than half of the series must be used.
  std::mt19937_64 random(11);
  const auto t = times(1000, 0.02);
  double used = 0.0;
  for (int trial = 0; trial < 50; ++trial) {
    auto value = autoregression(1000, 0.9, random);
    for (double& v : value) v = 1.0 + 0.1 * std::sqrt(1.0 - 0.81) * v;
    const Steady s = find_steady(t, value, {.minimum_duration = 20.0 / 3.0});
    used += s.steady ? static_cast<double>(s.last - s.first) / 1000.0 : 0.0;
  }
  EXPECT_GT(used / 50.0, 0.5);
}

TEST(SteadySpan, CriteriaOfAnImpactWaitForTheSplash) {
  const auto fast = impact_steady_criteria({.velocity = 19.62, .gravity = 9.81, .arrival = 0.25}, 10.25);  // 2 v/g = 4 s, 6 s are left
  EXPECT_DOUBLE_EQ(fast.earliest, 4.25);
  EXPECT_DOUBLE_EQ(fast.minimum_duration, 2.0);
  EXPECT_DOUBLE_EQ(impact_steady_criteria({.velocity = 19.62, .gravity = 9.81}, 7.0).minimum_duration, 2.0) << "v/g";
  EXPECT_DOUBLE_EQ(impact_steady_criteria({.velocity = 0.0, .gravity = 9.81}, 60.0).minimum_duration, 20.0) << "a third of what is left";
  EXPECT_THROW((void)impact_steady_criteria({.velocity = 1.0, .gravity = 0.0}, 1.0), ConfigError);
  EXPECT_THROW((void)impact_steady_criteria({.velocity = -1.0, .gravity = 9.81}, 1.0), ConfigError);
}

TEST(SteadySpan, LiesWhereTheSnowThatArrivesIsConstant) {
  const ImpactFlow flow{.velocity = 9.81, .constant = {3.0, 9.0}};
  const auto criteria = impact_steady_criteria(flow, 12.0);
  EXPECT_DOUBLE_EQ(criteria.earliest, 5.0) << "2 v/g after the first of it";
  EXPECT_DOUBLE_EQ(criteria.minimum_duration, 4.0 / 3.0);
  const auto t = times(601, 0.02);
  std::vector<double> value(601, 2.0);
  for (std::size_t i = 0; i < 601; ++i) value[i] = t[i] < 3.0 ? 5.0 : t[i] > 9.0 ? 0.5 : 2.0;
  const Steady s = find_steady(t, value, criteria);
  ASSERT_TRUE(s.steady);
  EXPECT_NEAR(s.from, 5.0, 0.021);
  EXPECT_NEAR(s.to, 9.0, 0.021);
  EXPECT_EQ(s.last - s.first, 201U);
}

TEST(SteadySpan, OfNothingDoesNotExist) {
  const auto t = times(500, 0.02);
  EXPECT_FALSE(find_steady(t, std::vector<double>(500, 0.0), {}).steady);
}

TEST(SteadySpan, OfASeriesThatEndsTooSoonDoesNotExist) {
  const auto t = times(20, 0.02);
  const std::vector<double> value(20, 1.0);
  EXPECT_FALSE(find_steady(t, value, impact_steady_criteria({.velocity = 12.43, .gravity = 9.81}, t.back())).steady);
  EXPECT_FALSE(find_steady({}, {}, {}).steady);
}

TEST(SteadySpan, RefusesSeriesThatAreNotOne) {
  const std::vector<double> one{1.0}, two{1.0, 2.0}, back{2.0, 1.0}, nan{1.0, std::nan("")};
  EXPECT_THROW((void)find_steady(one, two, {}), ConfigError);
  EXPECT_THROW((void)find_steady(back, two, {}), ConfigError);
  EXPECT_THROW((void)find_steady(two, nan, {}), ConfigError);
}

TEST(MeanEstimate, OfIndependentSamplesHasTheTextbookError) {
  std::mt19937_64 random(1);
  const auto value = autoregression(100000, 0.0, random);
  const MeanEstimate m = estimate_mean(value);
  EXPECT_EQ(m.batches, 20);
  EXPECT_EQ(m.samples, 100000u);
  // The standard error from 20 batches scatters by 1/sqrt(2 * 19) = 16 %: four of these.
  EXPECT_NEAR(m.standard_error * std::sqrt(1e5), 1.0, 0.65);
  EXPECT_LE(m.effective_samples, 1e5);
}

TEST(MeanEstimate, CoversTheTrueMeanOfCorrelatedSamples) {
  // AR(1): the integrated autocorrelation time is (1 + phi)/(1 - phi) samples; every case has at least ten of them. The 95 % interval of
  // Student's t must cover the true mean 0 in about 95 % of the trials: here in 90 to 98 %. 500 trials: a binomial standard deviation of 1
  // %; batch means of short series are known to fall a few per cent short, because neighbouring batches still resemble each other. Ignoring
  // correlation would cover 35 % at phi = 0.9.
  struct Case {
    std::size_t samples;
    double phi;
  };
  const auto student = [](int batches) { return batches == 20 ? 2.093 : batches == 10 ? 2.262 : 2.776; };
  for (const auto& c : {Case{200, 0.0}, Case{200, 0.9}, Case{1000, 0.9}, Case{1000, 0.98}, Case{2000, 0.95}}) {
    std::mt19937_64 random(17);
    int covered = 0;
    double error_squared = 0.0, mean_squared = 0.0;
    for (int trial = 0; trial < 500; ++trial) {
      const MeanEstimate m = estimate_mean(autoregression(c.samples, c.phi, random));
      covered += std::abs(m.mean) <= student(m.batches) * m.standard_error ? 1 : 0;
      error_squared += m.standard_error * m.standard_error;
      mean_squared += m.mean * m.mean;
    }
    EXPECT_GE(covered, 450) << c.samples << " samples, phi " << c.phi;
    EXPECT_LE(covered, 490) << c.samples << " samples, phi " << c.phi;
    // The estimated error against the scatter of the means that it estimates: the known shortfall grows as the series gets shorter.
    const double ratio = std::sqrt(error_squared / mean_squared);
    EXPECT_GT(ratio, 0.8) << c.samples << " samples, phi " << c.phi;
    EXPECT_LT(ratio, 1.1) << c.samples << " samples, phi " << c.phi;
  }
}

TEST(MeanEstimate, EffectiveSamplesFollowTheCorrelation) {
  // n (1 - phi)/(1 + phi) = 2052 for n = 39000, phi = 0.9; average over 40 trials of a figure that scatters by about 40 % each and is
  // biased upward by the reciprocal of a chi-square of 19 degrees, 19/17.
  std::mt19937_64 random(23);
  double effective = 0.0;
  for (int trial = 0; trial < 40; ++trial) effective += estimate_mean(autoregression(39000, 0.9, random)).effective_samples / 40.0;
  EXPECT_NEAR(effective / (2052.6 * 19.0 / 17.0), 1.0, 0.2);  // three times 40 %/sqrt(40)
}

TEST(MeanEstimate, IsExactForConstantsAndScalesWithTheUnit) {
  const MeanEstimate constant = estimate_mean(std::vector<double>(100, 3.0));
  EXPECT_EQ(constant.mean, 3.0);
  EXPECT_EQ(constant.standard_error, 0.0);
  EXPECT_EQ(constant.effective_samples, 100.0);
  std::mt19937_64 random(29);
  auto value = autoregression(500, 0.7, random);
  const MeanEstimate a = estimate_mean(value);
  for (double& v : value) v *= 1024.0;
  const MeanEstimate b = estimate_mean(value);
  EXPECT_EQ(b.mean, 1024.0 * a.mean);
  EXPECT_EQ(b.standard_error, 1024.0 * a.standard_error);
  EXPECT_EQ(b.effective_samples, a.effective_samples);
}

TEST(MeanEstimate, LeavesOutUndefinedSamplesAndSaysSo) {
  std::vector<double> value(30, 1.0);
  value[3] = value[17] = std::nan("");
  EXPECT_EQ(estimate_mean(value).mean, 1.0);
  EXPECT_EQ(estimate_mean(value).samples, 28u);
  EXPECT_TRUE(std::isnan(estimate_mean({}).mean));
  const MeanEstimate few = estimate_mean(std::vector<double>{1.0, 2.0, 3.0});
  EXPECT_EQ(few.mean, 2.0);
  EXPECT_TRUE(std::isnan(few.standard_error));
}

}  // namespace
}  // namespace mpm
