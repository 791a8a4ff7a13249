#include "validation/harness/grid_convergence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mpm/error.hpp"

namespace mpm::validation {
namespace {

TEST(RecordGridStudy, RecordsStudyPlotAndNoteOfEveryFigure) {
  CaseResult result;
  std::vector<double> asked;
  const auto studies =
      record_grid_study(result, "block", SweepKind::cell_size, {0.1, 0.4, 0.2}, {{"height", "m", 1.0, 2.0}, {"force", "N"}}, [&](double h) {
        asked.push_back(h);
        return std::vector<Figure>{{2.0 + 0.5 * h}, {10.0 - h, 0.001}};
      });
  EXPECT_EQ(asked, (std::vector{0.4, 0.2, 0.1}));  // coarse first
  ASSERT_EQ(studies.size(), 2u);
  EXPECT_NEAR(studies[0].study->extrapolated, 2.0, 1e-12);
  ASSERT_EQ(result.studies.size(), 2u);
  EXPECT_EQ(result.studies[1].quantity, "force");
  EXPECT_EQ(result.studies[1].unit, "N");
  EXPECT_EQ(result.studies[1].size_label, "cell size [m]");
  ASSERT_EQ(result.plots.size(), 1u);  // errors, where there is an exact value
  EXPECT_EQ(result.plots[0].id, "block-1");
  EXPECT_TRUE(result.plots[0].log_x && result.plots[0].log_y);
  EXPECT_NEAR(result.plots[0].series[0].y.back(), 0.05, 1e-12);
  EXPECT_NEAR(result.plots[0].series[1].y.back(), 0.05, 1e-12);  // on the slope
  ASSERT_EQ(result.notes.size(), 2u);
  EXPECT_NE(result.notes[1].find("9.9 N, numerical uncertainty"), std::string::npos) << result.notes[1];
  EXPECT_NE(result.notes[1].find("statistical (two standard errors) 0.02 %"), std::string::npos) << result.notes[1];
}

TEST(RecordGridStudy, PassesTheVerdictOfNoiseOnToTheReport) {
  CaseResult result;
  const auto studies = record_grid_study(result, "noisy", SweepKind::cfl, {0.4, 0.2, 0.1}, {{"force", "N"}}, [](double h) {
    return std::vector<Figure>{{10.0 + h, 1.0}};
  });
  EXPECT_FALSE(studies[0].asymptotic);
  EXPECT_FALSE(result.studies[0].study.asymptotic);
  EXPECT_NE(result.studies[0].study.remark.find("statistical error"), std::string::npos);
}

TEST(RecordGridStudy, TellsMissingFiguresAndScatter) {
  CaseResult result;
  (void)record_grid_study(result, "gap", SweepKind::cell_size, {0.4, 0.2, 0.1}, {{"force", "N"}},
                          [](double h) { return std::vector<Figure>{{h < 0.3 ? Figure::none : 1.0}}; });
  EXPECT_TRUE(result.studies.empty());
  EXPECT_NE(result.notes[0].find("no figure at 0.2, 0.1"), std::string::npos) << result.notes[0];
  (void)record_grid_study(result, "offset", SweepKind::offset, {0.0, 0.5}, {{"force", "N"}},
                          [](double o) { return std::vector<Figure>{{1.0 + o}}; });
  EXPECT_TRUE(result.studies.empty());
  EXPECT_NE(result.notes[1].find("scatter over 2 values"), std::string::npos) << result.notes[1];
  EXPECT_THROW(
      (void)record_grid_study(result, "few", SweepKind::cfl, {0.1}, {{"a", ""}, {"b", ""}}, [](double) { return std::vector<Figure>(1); }),
      ConfigError);
}

}  // namespace
}  // namespace mpm::validation
