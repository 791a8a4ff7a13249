#include "validation/harness/grid_convergence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libmpm/base/error.hpp"

namespace mpm::validation {
namespace {

TEST(RecordConvergence, RecordsConvergencePlotAndNoteOfEveryQuantity) {
  CaseResult result;
  std::vector<double> asked;
  const auto judged = record_convergence(result, "block", SweepKind::cell_size, {0.1, 0.4, 0.2},
                                         {{"height", "m", 1.0, 2.0}, {"force", "N"}}, [&](double h) {
                                           asked.push_back(h);
                                           return std::vector<Metric>{{2.0 + 0.5 * h}, {10.0 - h, 0.001}};
                                         });
  EXPECT_EQ(asked, (std::vector{0.4, 0.2, 0.1}));  // coarse first
  ASSERT_EQ(judged.size(), 2u);
  EXPECT_NEAR(judged[0].convergence->extrapolated, 2.0, 1e-12);
  ASSERT_EQ(result.convergences.size(), 2u);
  EXPECT_EQ(result.convergences[1].quantity, "force");
  EXPECT_EQ(result.convergences[1].unit, "N");
  EXPECT_EQ(result.convergences[1].size_label, "cell size [m]");
  ASSERT_EQ(result.plots.size(), 1u);  // errors, where there is an exact value
  EXPECT_EQ(result.plots[0].id, "block-1");
  EXPECT_TRUE(result.plots[0].log_x && result.plots[0].log_y);
  EXPECT_NEAR(result.plots[0].series[0].y.back(), 0.05, 1e-12);
  EXPECT_NEAR(result.plots[0].series[1].y.back(), 0.05, 1e-12);  // on the slope
  ASSERT_EQ(result.notes.size(), 2u);
  EXPECT_NE(result.notes[1].find("9.9 N, numerical uncertainty"), std::string::npos) << result.notes[1];
  EXPECT_NE(result.notes[1].find("statistical (two standard errors) 0.02 %"), std::string::npos) << result.notes[1];
}

TEST(RecordConvergence, PassesTheVerdictOfNoiseOnToTheReport) {
  CaseResult result;
  const auto judged = record_convergence(result, "noisy", SweepKind::cfl, {0.4, 0.2, 0.1}, {{"force", "N"}}, [](double h) {
    return std::vector<Metric>{{10.0 + h, 1.0}};
  });
  EXPECT_FALSE(judged[0].asymptotic);
  EXPECT_FALSE(result.convergences[0].convergence.asymptotic);
  EXPECT_NE(result.convergences[0].convergence.remark.find("statistical error"), std::string::npos);
}

TEST(RecordConvergence, ReportsMissingValuesAndScatter) {
  CaseResult result;
  (void)record_convergence(result, "gap", SweepKind::cell_size, {0.4, 0.2, 0.1}, {{"force", "N"}},
                           [](double h) { return std::vector<Metric>{{h < 0.3 ? Metric::none : 1.0}}; });
  EXPECT_TRUE(result.convergences.empty());
  EXPECT_NE(result.notes[0].find("no value at 0.2, 0.1"), std::string::npos) << result.notes[0];
  (void)record_convergence(result, "offset", SweepKind::offset, {0.0, 0.5}, {{"force", "N"}},
                           [](double o) { return std::vector<Metric>{{1.0 + o}}; });
  EXPECT_TRUE(result.convergences.empty());
  EXPECT_NE(result.notes[1].find("scatter over 2 values"), std::string::npos) << result.notes[1];
  EXPECT_THROW(
      (void)record_convergence(result, "few", SweepKind::cfl, {0.1}, {{"a", ""}, {"b", ""}}, [](double) { return std::vector<Metric>(1); }),
      ConfigError);
}

}  // namespace
}  // namespace mpm::validation
