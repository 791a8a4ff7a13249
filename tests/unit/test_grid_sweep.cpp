#include "mpm/grid_sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mpm/error.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/table.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// A short fall of a small block: no impact, some hundred particle-steps a size.
Case falling_block() {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body(Vec3(0.0, 0.0, 0.0), Vec3(1.0, 1.0, 1.0))};
  c.domain = {.min = Vec3::Constant(-5.0), .max = Vec3::Constant(5.0)};
  c.output.duration = 0.02;
  c.output.series_per_second = 100.0;
  c.output.frames_per_second = 0.0;
  return c;
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

TEST(SweptCase, ChangesOneKeyAndPassesTheChecksOfACaseFile) {
  const Case c = testing::small_avalanche();
  Case expected = c;
  expected.numerics.cell_size = 0.125;
  EXPECT_EQ(swept_case(c, {SweepKind::cell_size, {}, {}}, 0.125), expected);
  expected = c;
  expected.numerics.cfl = 0.8;
  EXPECT_EQ(swept_case(c, {SweepKind::cfl, {}, {}}, 0.8), expected);
  expected = c;
  expected.numerics.particles_per_cell = 27;
  EXPECT_EQ(swept_case(c, {SweepKind::particles_per_cell, {}, {}}, 27.0), expected);
  expected = c;
  expected.numerics.grid_offset = {0.25, 0.0, 0.25};  // the mirror plane y = 0 stays on the grid
  EXPECT_EQ(swept_case(c, {SweepKind::offset, {}, {}}, 0.25), expected);
  expected.numerics.grid_offset = {0.0, 0.0, 0.25};
  EXPECT_EQ(swept_case(c, {SweepKind::offset, {}, "z"}, 0.25), expected);
  EXPECT_THROW((void)swept_case(c, {SweepKind::offset, {}, "y"}, 0.25), ConfigError);
  EXPECT_THROW((void)swept_case(c, {SweepKind::particles_per_cell, {}, {}}, 9.0), ConfigError);
  EXPECT_THROW((void)swept_case(c, {SweepKind::particles_per_cell, {}, {}}, 8.5), ConfigError);
  EXPECT_THROW((void)swept_case(c, {SweepKind::cell_size, {}, {}}, 5.0), ConfigError);
}

TEST(FigureOf, FindsFiguresComponentsAndStandardErrors) {
  const std::string json = R"({"title": "t", "steady": true, "runup_mean_m": 3.5, "runup_standard_error_m": 0.25,
    "force_mean_n": [1.0, 2.0, 3.0], "force_standard_error_n": [0.1, 0.2, null], "pressure_height_mean_m": null, "steps": 7})";
  EXPECT_EQ(figure_of(json, "runup_mean_m").value, 3.5);
  EXPECT_EQ(figure_of(json, "runup_mean_m").standard_error, 0.25);
  EXPECT_EQ(figure_of(json, "force_mean_n[1]").value, 2.0);
  EXPECT_EQ(figure_of(json, "force_mean_n.y").value, 2.0);
  EXPECT_EQ(figure_of(json, "force_mean_n.y").standard_error, 0.2);
  EXPECT_TRUE(std::isnan(figure_of(json, "force_mean_n.z").standard_error));
  EXPECT_EQ(figure_of(json, "steps").value, 7.0);
  EXPECT_TRUE(std::isnan(figure_of(json, "pressure_height_mean_m").value));
  const auto message = [&](const char* name) {
    try {
      (void)figure_of(json, name);
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(message("runup_meen_m").find("did you mean runup_mean_m?"), std::string::npos);
  EXPECT_NE(message("force_mean_n").find("it is a vector: give force_mean_n[0]"), std::string::npos);
  EXPECT_NE(message("force_mean_n[3]").find("no such figure"), std::string::npos);
  EXPECT_NE(message("title").find("is no number"), std::string::npos);
  EXPECT_NE(message("steady").find("is no number"), std::string::npos);
}

std::vector<Figure> figures(const std::vector<double>& values, double standard_error = Figure::none) {
  std::vector<Figure> result;
  for (const double v : values) result.push_back({v, standard_error});
  return result;
}

TEST(FigureStudy, OfAPowerLawHasItsOrderLimitAndErrors) {
  const std::vector<double> h{0.4, 0.2, 0.1, 0.05};
  std::vector<double> f;
  for (const double x : h) f.push_back(2.0 + 0.5 * x);
  const FigureStudy s = study_figure("f", SweepKind::cell_size, h, figures(f), 2.0, 1.0);
  ASSERT_TRUE(s.study);
  EXPECT_TRUE(s.asymptotic) << s.verdict;
  EXPECT_NEAR(s.study->order, 1.0, 1e-9);
  EXPECT_NEAR(s.study->extrapolated, 2.0, 1e-12);
  EXPECT_EQ(s.study->triples.size(), 2u);
  ASSERT_EQ(s.error_order.size(), 3u);
  for (const double p : s.error_order) EXPECT_NEAR(p, 1.0, 1e-12);
  EXPECT_NEAR(s.error.back(), 0.025, 1e-12);
  EXPECT_GE(s.uncertainty, s.error.back());  // what the uncertainty is for
  EXPECT_EQ(s.highest, f.front());
}

TEST(FigureStudy, SaysWhenTheDifferencesDrownInStatisticalErrors) {
  const std::vector<double> h{0.4, 0.2, 0.1}, f{2.2, 2.1, 2.05};
  EXPECT_TRUE(study_figure("f", SweepKind::cell_size, h, figures(f, 0.01)).asymptotic);
  const FigureStudy noisy = study_figure("f", SweepKind::cell_size, h, figures(f, 0.02));  // 2 sqrt(2) 0.02 = 0.057 > 0.05
  EXPECT_FALSE(noisy.asymptotic);
  EXPECT_NE(noisy.verdict.find("not asymptotic: the two finest differ by 0.05, within twice the statistical error"), std::string::npos)
      << noisy.verdict;
}

TEST(FigureStudy, NeverSkipsAMissingFigureInSilence) {
  const std::vector<double> h{0.4, 0.3, 0.2, 0.1};
  const FigureStudy s = study_figure("f", SweepKind::cell_size, h, figures({2.4, Figure::none, 2.2, 2.1}));
  ASSERT_TRUE(s.study);
  EXPECT_EQ(s.study->size, (std::vector{0.4, 0.2, 0.1}));
  EXPECT_NE(s.verdict.find("no figure at 0.3"), std::string::npos) << s.verdict;
  const FigureStudy two = study_figure("f", SweepKind::cell_size, {0.4, 0.2, 0.1}, figures({2.4, 2.2, Figure::none}));
  EXPECT_FALSE(two.study);
  EXPECT_FALSE(two.asymptotic);
  EXPECT_NE(two.verdict.find("values only: 2 sizes"), std::string::npos) << two.verdict;
  EXPECT_NE(two.verdict.find("no figure at 0.1"), std::string::npos) << two.verdict;
}

TEST(FigureStudy, OfAParameterWithoutALimitIsItsScatter) {
  const FigureStudy s = study_figure("f", SweepKind::offset, {0.0, 0.25, 0.5}, figures({1.1, 0.9, 1.0}));
  EXPECT_FALSE(s.study);
  EXPECT_NEAR(s.uncertainty, 0.1, 1e-15);
  EXPECT_NE(s.verdict.find("half the range is 10 %"), std::string::npos) << s.verdict;
  EXPECT_TRUE(std::isnan(study_figure("f", SweepKind::offset, {0.0}, figures({1.0})).uncertainty));
}

TEST(RunSweep, RunsEachValueOnceAndTakesUpWhatIsFinished) {
  const testing::TemporaryDirectory directory;
  SweepOptions options;
  options.out = directory.path();
  options.threads = 1;
  const Sweep sweep{SweepKind::cell_size, {0.25, 0.5}, {}};
  const SweepResult first = run_sweep(falling_block(), sweep, options);
  ASSERT_TRUE(first.finished);
  ASSERT_EQ(first.points.size(), 2u);
  EXPECT_EQ(first.points[0].directory, directory / "dx_0.5");
  EXPECT_FALSE(first.points[0].reused);
  EXPECT_EQ(figure_of(first.points[0].results_json, "particles_final").value, 64.0);
  EXPECT_EQ(figure_of(first.points[1].results_json, "particles_final").value, 512.0);

  options.resume = true;
  const SweepResult again = run_sweep(falling_block(), {SweepKind::cell_size, {0.5, 0.25, 0.2}, {}}, options);
  ASSERT_EQ(again.points.size(), 3u);
  EXPECT_TRUE(again.points[0].reused);
  EXPECT_TRUE(again.points[1].reused);
  EXPECT_FALSE(again.points[2].reused);
  EXPECT_EQ(again.points[0].results_json, first.points[0].results_json);

  Case longer = falling_block();
  longer.output.duration = 0.03;
  EXPECT_FALSE(run_sweep(longer, sweep, options).points[0].reused);  // other figures: over another time
  options.resume = false;
  EXPECT_FALSE(run_sweep(longer, sweep, options).points[0].reused);
}

TEST(RunSweep, StopsOnRequestAndGoesOn) {
  const testing::TemporaryDirectory directory;
  SweepOptions options;
  options.out = directory.path();
  options.threads = 1;
  int samples = 0;
  options.poll = [&] { return ++samples == 3 ? Request::stop : Request::none; };  // inside the second run
  const Sweep sweep{SweepKind::cfl, {0.4, 0.2}, {}};
  const SweepResult stopped = run_sweep(falling_block(), sweep, options);
  EXPECT_FALSE(stopped.finished);
  EXPECT_EQ(stopped.points.size(), 1u);
  options.poll = {};
  options.resume = true;
  const SweepResult done = run_sweep(falling_block(), sweep, options);
  EXPECT_TRUE(done.finished);
  EXPECT_TRUE(done.points[0].reused);
  EXPECT_FALSE(done.points[1].reused);
}

TEST(SweepFiles, HoldTheStudyWithNullForWhatIsMissing) {
  const testing::TemporaryDirectory directory;
  const Sweep sweep{SweepKind::cell_size, {0.4, 0.2, 0.1}, {}};
  const std::vector<FigureStudy> studies{study_figure("f", sweep.kind, sweep.values, figures({2.4, 2.2, 2.1}), 2.0),
                                         study_figure("g", sweep.kind, sweep.values, figures({1.0, Figure::none, 1.0}))};
  const auto json = nlohmann::json::parse(sweep_json(falling_block(), sweep, {}, studies));
  EXPECT_EQ(json["sweep"], "cell_size_m");
  EXPECT_NEAR(json["figures"][0]["order"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(json["figures"][0]["triples"].size(), 1u);
  EXPECT_NEAR(json["figures"][0]["error"][2].get<double>(), 0.1, 1e-12);
  EXPECT_TRUE(json["figures"][1]["value"][1].is_null());
  EXPECT_FALSE(json["figures"][1].contains("order"));
  write_sweep_table(directory / "converge.csv", sweep, studies);
  const Table table = Table::read(directory / "converge.csv");
  EXPECT_EQ(table.numbers("cell_size_m"), sweep.values);
  EXPECT_EQ(table.numbers("f"), (std::vector{2.4, 2.2, 2.1}));
  EXPECT_TRUE(std::isnan(table.numbers("g")[1]));
  EXPECT_TRUE(table.has("f:error"));
}

}  // namespace
}  // namespace mpm
