/// From a case and a sweep to the runs of a grid study, and its files.

#include "libmpm/campaign/grid_study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/csv.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

TEST(GridStudy, ChangesOneKeyInEachRunAndChecksItAsACaseFile) {
  const Case c = testing::small_avalanche();
  const auto first_run = [&](SweepKind kind, double value, const std::string& axes = {}) {
    return make_grid_study(c, {kind, {value}, axes}, 1, 1).runs.at(0);
  };
  const auto expect = [](const CampaignRun& run, const std::string& name, const Case& expected) {
    EXPECT_EQ(run.name, name);
    EXPECT_EQ(run.case_hash, case_hash_text(expected)) << name;
  };
  Case expected = c;
  expected.numerics.cell_size = 0.125;
  expect(first_run(SweepKind::cell_size, 0.125), "dx0.125", expected);
  expected = c;
  expected.numerics.cfl = 0.8;
  expect(first_run(SweepKind::cfl, 0.8), "cfl0.8", expected);
  expected = c;
  expected.numerics.particles_per_cell = 27;
  expect(first_run(SweepKind::particles_per_cell, 27.0), "ppc27", expected);
  expected = c;
  expected.numerics.grid_offset = {0.25, 0.0, 0.25};  // the mirror plane y = 0 stays on the grid
  expect(first_run(SweepKind::offset, 0.25), "offset0.25", expected);
  expected.numerics.grid_offset = {0.0, 0.0, 0.25};
  expect(first_run(SweepKind::offset, 0.25, "z"), "offset0.25", expected);
  EXPECT_THROW((void)first_run(SweepKind::offset, 0.25, "y"), ConfigError);
  EXPECT_THROW((void)first_run(SweepKind::particles_per_cell, 9.0), ConfigError);
  EXPECT_THROW((void)first_run(SweepKind::particles_per_cell, 8.5), ConfigError);
  EXPECT_THROW((void)first_run(SweepKind::cell_size, 5.0), ConfigError);
}

TEST(GridStudy, NotesWhatMakesAStudyUnreliable) {
  Case c = testing::small_avalanche();
  c.obstacle->shape = BoxShape{.width = 1.75, .depth = 1.75};
  const auto notes = study_notes(c, {SweepKind::cell_size, {0.875, 0.8, 0.75}, {}});
  const auto holds = [&](const std::string& text) {
    return std::ranges::any_of(notes, [&](const std::string& note) { return note.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(holds("0.8 is only 1.07 times 0.75"));
  EXPECT_TRUE(holds("fewer than three cells across the obstacle at 0.875 (2 cells), 0.8 (2.19 cells), 0.75 (2.33 cells)"));
  EXPECT_TRUE(study_notes(Case{}, {SweepKind::cell_size, {0.4, 0.3}, {}}).empty());
}

std::vector<Metric> metrics(const std::vector<double>& values) {
  std::vector<Metric> result;
  for (const double v : values) result.push_back({v, Metric::none});
  return result;
}

TEST(ConvergeFiles, HoldTheVerdictsWithNullForMissingValues) {
  const testing::TemporaryDirectory directory;
  const Sweep sweep{SweepKind::cell_size, {0.4, 0.2, 0.1}, {}};
  const std::vector<MetricConvergence> judged{judge_metric("f", sweep.kind, sweep.values, metrics({2.4, 2.2, 2.1}), 2.0),
                                              judge_metric("g", sweep.kind, sweep.values, metrics({1.0, Metric::none, 1.0}))};
  const auto json = nlohmann::json::parse(converge_json(Case{}, sweep, {}, {}, judged));
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
