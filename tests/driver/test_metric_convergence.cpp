#include "libmpm/driver/metric_convergence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "libmpm/io/csv.hpp"
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

TEST(MetricConvergence, ReportsMissingValues) {
  const std::vector<double> h{0.4, 0.3, 0.2, 0.1};
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

TEST(ConvergeFiles, HoldTheVerdictsWithNullForMissingValues) {
  const testing::TemporaryDirectory directory;
  const Sweep sweep{SweepKind::cell_size, {0.4, 0.2, 0.1}, {}};
  const std::vector<MetricConvergence> judged{judge_metric("f", sweep.kind, sweep.values, metrics({2.4, 2.2, 2.1}), 2.0),
                                              judge_metric("g", sweep.kind, sweep.values, metrics({1.0, Metric::none, 1.0}))};
  const auto json = nlohmann::json::parse(converge_json(Case{}, sweep, {}, judged));
  EXPECT_EQ(json["sweep"], "cell_size_m");
  EXPECT_NEAR(json["metrics"][0]["order"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(json["metrics"][0]["triples"].size(), 1u);
  EXPECT_NEAR(json["metrics"][0]["error"][2].get<double>(), 0.1, 1e-12);
  EXPECT_TRUE(json["metrics"][1]["value"][1].is_null());
  EXPECT_FALSE(json["metrics"][1].contains("order"));
  write_converge_table(directory / "converge.csv", sweep, judged);
  const Table table = Table::read(directory / "converge.csv");
  EXPECT_EQ(table.numbers("cell_size_m"), sweep.values);
  EXPECT_EQ(table.numbers("f"), (std::vector{2.4, 2.2, 2.1}));
  EXPECT_TRUE(std::isnan(table.numbers("g")[1]));
  EXPECT_TRUE(table.has("f:error"));
}

}  // namespace
}  // namespace mpm
