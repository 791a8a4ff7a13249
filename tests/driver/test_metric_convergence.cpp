#include "libmpm/driver/metric_convergence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libmpm/base/error.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

std::vector<Metric> metrics(const std::vector<double>& values, double standard_error = Metric::none) {
  std::vector<Metric> result;
  for (const double v : values) result.push_back({v, standard_error});
  return result;
}

TEST(MetricConvergence, OfAPowerLawHasItsOrderLimitAndErrors) {
  const std::vector<double> h{0.4, 0.2, 0.1, 0.05};
  std::vector<double> f;
  for (const double x : h) f.push_back(2.0 + 0.5 * x);
  const MetricConvergence s = judge_metric("f", SweepKind::cell_size, h, metrics(f), 2.0, 1.0);
  ASSERT_TRUE(s.convergence);
  EXPECT_TRUE(s.asymptotic) << s.verdict;
  EXPECT_NEAR(s.convergence->order, 1.0, 1e-9);
  EXPECT_NEAR(s.convergence->extrapolated, 2.0, 1e-12);
  EXPECT_EQ(s.convergence->triples.size(), 2u);
  ASSERT_EQ(s.error_order.size(), 3u);
  for (const double p : s.error_order) EXPECT_NEAR(p, 1.0, 1e-12);
  EXPECT_NEAR(s.error.back(), 0.025, 1e-12);
  EXPECT_GE(s.uncertainty, s.error.back());  // what the uncertainty is for
  EXPECT_EQ(s.highest, f.front());
}

TEST(MetricConvergence, SaysWhenTheDifferencesDrownInStatisticalErrors) {
  const std::vector<double> h{0.4, 0.2, 0.1}, f{2.2, 2.1, 2.05};
  EXPECT_TRUE(judge_metric("f", SweepKind::cell_size, h, metrics(f, 0.01)).asymptotic);
  const MetricConvergence noisy = judge_metric("f", SweepKind::cell_size, h, metrics(f, 0.02));  // 2 sqrt(2) 0.02 = 0.057 > 0.05
  EXPECT_FALSE(noisy.asymptotic);
  EXPECT_NE(noisy.verdict.find("not asymptotic: the two finest differ by 0.05, within twice the statistical error"), std::string::npos)
      << noisy.verdict;
}

/// The run-up of a mast with two cells across it: the grids are so close that the values agree by chance; at w/7 it is 6 % higher.
TEST(MetricConvergence, StatesNoUncertaintyForSizesThatAreTooClose) {
  const MetricConvergence s = judge_metric("runup_mean_m", SweepKind::cell_size, {0.875, 0.8, 0.75}, metrics({7.747, 7.7585, 7.76}, 0.02));
  EXPECT_FALSE(s.convergence);
  EXPECT_TRUE(std::isnan(s.uncertainty));
  EXPECT_NE(s.verdict.find("values only: 1 size"), std::string::npos) << s.verdict;
  EXPECT_NE(s.verdict.find("not judged: 0.875, 0.8, less than 1.2 times the next finer size"), std::string::npos) << s.verdict;
  EXPECT_NE(quote(s).find("runup_mean_m = 7.76, uncertainty not known: values only"), std::string::npos) << quote(s);
  const MetricConvergence kept = judge_metric("f", SweepKind::cell_size, {0.8, 0.42, 0.4, 0.2}, metrics({2.8, 7.0, 2.4, 2.2}));
  EXPECT_EQ(kept.convergence->size, (std::vector{0.8, 0.4, 0.2}));
}

/// w/3, w/4, w/5 and w/7 of a mast: no order, and one line that says what to quote.
TEST(MetricConvergence, QuotesOneValueWithGridAndStatisticalErrorAndSaysWhy) {
  const std::vector<double> h{1.75 / 3, 1.75 / 4, 0.35, 0.25}, f{6.02, 6.62, 6.27, 6.22};
  const MetricConvergence four = judge_metric("runup_mean_m", SweepKind::cell_size, h, metrics(f, 0.05));
  EXPECT_TRUE(std::isnan(four.convergence->order)) << "the two finest differ by noise";
  EXPECT_NEAR(four.uncertainty, 3.0 * 0.40, 1e-12);
  EXPECT_GE(four.uncertainty, four.convergence->gci * f.back());
  EXPECT_NEAR(four.total_uncertainty, std::hypot(1.2, 0.1), 1e-12);
  EXPECT_EQ(
      quote(four),
      "runup_mean_m = 6.22 +- 1.2 (19 %): cell_size_m +- 1.2 (3 times the range of the three finest grids; no order of convergence is "
      "observed), statistics +- 0.1 (two standard errors)");
  const MetricConvergence three =
      judge_metric("runup_mean_m", SweepKind::cell_size, {h.begin(), h.end() - 1}, metrics({f.begin(), f.end() - 1}, 0.05));
  EXPECT_LE(four.uncertainty, three.uncertainty) << "a further grid does not make the result worse";
}

TEST(MetricConvergence, ReportsMissingValues) {
  const std::vector<double> h{0.4, 0.3, 0.2, 0.1};
  const MetricConvergence coarse = judge_metric("f", SweepKind::cell_size, h, metrics({2.4, 2.3, 2.2, Metric::none}));
  EXPECT_TRUE(quote(coarse).starts_with("f at 0.2 (none at 0.1) = 2.2")) << quote(coarse);
  const MetricConvergence s = judge_metric("f", SweepKind::cell_size, h, metrics({2.4, Metric::none, 2.2, 2.1}));
  ASSERT_TRUE(s.convergence);
  EXPECT_EQ(s.convergence->size, (std::vector{0.4, 0.2, 0.1}));
  EXPECT_NE(s.verdict.find("no value at 0.3"), std::string::npos) << s.verdict;
  const MetricConvergence two = judge_metric("f", SweepKind::cell_size, {0.4, 0.2, 0.1}, metrics({2.4, 2.2, Metric::none}));
  EXPECT_FALSE(two.convergence);
  EXPECT_FALSE(two.asymptotic);
  EXPECT_NE(two.verdict.find("values only: 2 sizes"), std::string::npos) << two.verdict;
  EXPECT_NE(two.verdict.find("no value at 0.1"), std::string::npos) << two.verdict;
}

TEST(MetricConvergence, OfAParameterWithoutALimitIsItsScatter) {
  const MetricConvergence s = judge_metric("f", SweepKind::offset, {0.0, 0.25, 0.5}, metrics({1.1, 0.9, 1.0}));
  EXPECT_FALSE(s.convergence);
  EXPECT_NEAR(s.uncertainty, 0.1, 1e-15);
  EXPECT_NE(s.verdict.find("half the range is 10 %"), std::string::npos) << s.verdict;
  EXPECT_TRUE(std::isnan(judge_metric("f", SweepKind::offset, {0.0}, metrics({1.0})).uncertainty));
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

}  // namespace
}  // namespace mpm
