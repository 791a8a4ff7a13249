#include "validation/harness/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/snapshot.hpp"
#include "support/typical_shapes.hpp"
#include "validation/harness/check_text.hpp"
#include "validation/harness/junit.hpp"
#include "validation/harness/orders.hpp"
#include "validation/harness/results_json.hpp"
#include "validation/harness/setup.hpp"
#include "validation/harness/tables.hpp"

namespace mpm::validation {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();

CaseResult good_case() {
  CaseResult r;
  r.name = "good";
  r.title = "A case that holds";
  r.check_relative(Label::verification, "height", 1.01, 1.0, "m", 0.02, "because");
  return r;
}

CaseResult bad_case() {
  CaseResult r;
  r.name = "bad";
  r.title = "A case that <fails> & says so";
  r.check_absolute(Label::validation, "pressure", 5.0, 3.0, "Pa", 1.0, "because");
  r.check_absolute(Label::validation, "mass", 1.0, 1.0, "kg", 0.0, "exact");
  return r;
}

/// A fresh directory that vanishes with the test.
struct Scratch {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("mpm_report_" + std::to_string(::getpid()));
  Scratch() {
    std::filesystem::remove_all(path);
    make_directory(path);
  }
  ~Scratch() { std::filesystem::remove_all(path); }
};

CaseContext context_in(const std::filesystem::path& path) {
  return {Level::quick, 1, path, path, [](const std::string&) {}};
}

/// Runs that another solver made.
struct Elsewhere : RunSource {
  RunCost play(const validation::Setup&, const Visitor&) const override { return {}; }
};

TEST(ReferenceCurve, GoesFromEndToEndInEvenSteps) {
  const Series s = reference_curve("square", 1.0, 3.0, 4, [](double x) { return x * x; });
  EXPECT_EQ(s.style, Series::Style::reference);
  EXPECT_EQ(s.x, (std::vector{1.0, 1.5, 2.0, 2.5, 3.0}));
  EXPECT_EQ(s.y, (std::vector{1.0, 2.25, 4.0, 6.25, 9.0}));
}

TEST(Check, StaysWhereItIsWhileOthersFollow) {
  CaseResult r;
  Check& first = r.check_relative(Label::verification, "q", 1.0, 1.0, "m", 0.1, "");
  for (int i = 0; i < 1000; ++i) r.check_relative(Label::verification, "other", 1.0, 1.0, "m", 0.1, "");
  first.observed_order = 2.0;
  EXPECT_EQ(&first, &r.checks.front());
  EXPECT_EQ(r.checks.front().observed_order, 2.0);
}

TEST(Check, HoldsExactlyUpToItsTolerance) {
  CaseResult r;
  EXPECT_TRUE(r.check_relative(Label::verification, "q", 1.25, 1.0, "m", 0.25, "").passed);
  EXPECT_FALSE(r.check_relative(Label::verification, "q", 1.2500001, 1.0, "m", 0.25, "").passed);
  EXPECT_TRUE(r.check_absolute(Label::verification, "q", -1.0, 1.0, "m", 2.0, "").passed);
  EXPECT_TRUE(r.check_at_most(Label::verification, "q", -1e9, 1.0, "m", 0.0, "").passed);
  EXPECT_FALSE(r.check_at_most(Label::verification, "q", 1.2, 1.0, "m", 0.1, "").passed);
  EXPECT_TRUE(r.check_order(Label::verification, "p", 1.9, 1.8, 2.2, "").passed);
  EXPECT_FALSE(r.check_order(Label::verification, "p", 1.7, 1.8, 2.2, "").passed);
}

TEST(Check, WithANanAnywhereFails) {
  CaseResult r;
  EXPECT_FALSE(r.check_relative(Label::verification, "q", nan, 1.0, "m", 1e300, "").passed);
  EXPECT_FALSE(r.check_absolute(Label::verification, "q", 1.0, nan, "m", 1e300, "").passed);
  EXPECT_FALSE(r.check_at_most(Label::verification, "q", nan, 1.0, "m", 1e300, "").passed);
  EXPECT_FALSE(r.check_absolute(Label::verification, "q", 1.0, 1.0, "m", nan, "").passed);
  EXPECT_FALSE(r.check_order(Label::verification, "p", nan, 0.0, 1e300, "").passed);
  EXPECT_FALSE(r.check_relative(Label::verification, "q", 1.0, 0.0, "m", 1e300, "").passed);  // a relative error needs a reference
  EXPECT_FALSE(r.passed());
}

/// A target of 1, known to be missed by at most 20 % upwards.
Check& missed(CaseResult& r, double value) {
  return r.check_relative(Label::verification, "speed", value, 1.0, "m/s", 0.02, "because").known_miss(1.2, "the front broadens");
}

TEST(KnownMiss, HoldsBetweenTargetAndBoundOnly) {
  CaseResult r;
  EXPECT_EQ(missed(r, 1.01).verdict(), Verdict::ok);
  EXPECT_EQ(missed(r, 1.1).verdict(), Verdict::not_met);
  EXPECT_EQ(missed(r, 1.2).verdict(), Verdict::not_met);
  EXPECT_TRUE(r.passed());
  for (const double value : {1.2001, 0.9, nan, 1.0 / 0.0}) EXPECT_EQ(missed(r, value).verdict(), Verdict::failed) << value;
  EXPECT_FALSE(r.passed());
}

TEST(KnownMiss, OfAResultThatIsTooSmallHasALowerBound) {
  CaseResult r;
  const auto verdict = [&](double order) {
    return r.check_order(Label::verification, "p", order, 1.8, 2.6, "").known_miss(1.5, "").verdict();
  };
  EXPECT_EQ(verdict(1.9), Verdict::ok);
  EXPECT_EQ(verdict(1.6), Verdict::not_met);
  EXPECT_EQ(verdict(1.4), Verdict::failed);
  EXPECT_EQ(verdict(2.7), Verdict::failed);  // on the other side nothing is known to be missed
}

TEST(KnownMiss, OfAOneSidedBoundIsAWiderBound) {
  CaseResult r;
  const auto verdict = [&](double value) {
    return r.check_at_most(Label::verification, "q", value, 1.0, "", 0.1, "").known_miss(1.5, "").verdict();
  };
  EXPECT_EQ(verdict(-5.0), Verdict::ok);
  EXPECT_EQ(verdict(1.4), Verdict::not_met);
  EXPECT_EQ(verdict(1.6), Verdict::failed);
}

TEST(KnownMiss, NeedsABoundOnOneSideOfTheReference) {
  CaseResult r;
  Check& c = r.check_relative(Label::verification, "speed", 1.1, 1.0, "m/s", 0.02, "");
  for (const double bound : {1.0, nan, 1.0 / 0.0}) EXPECT_THROW(c.known_miss(bound, ""), std::invalid_argument) << bound;
  try {
    c.known_miss(1.0, "");
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "known miss of 'speed': its bound is 1; it must be a number above or below the reference 1");
  }
  EXPECT_EQ(c.verdict(), Verdict::failed);
}

TEST(KnownMiss, WithABoundWithinTheToleranceDoesNotApply) {  // a tolerance that grows with a statistical error may pass the bound
  CaseResult r;
  const auto verdict = [&](double value) {
    return r.check_relative(Label::verification, "speed", value, 1.0, "m/s", 0.1, "").known_miss(1.05, "").verdict();
  };
  EXPECT_EQ(verdict(1.08), Verdict::ok);
  EXPECT_EQ(verdict(1.12), Verdict::failed);
}

TEST(KnownMiss, IsPartOfTheVerdictOfItsCase) {
  CaseResult r = good_case();
  EXPECT_NE(case_table({r}, {}).find("| ok "), std::string::npos);
  missed(r, 1.1);
  EXPECT_NE(case_table({r}, {}).find("| ok, 1 not met |"), std::string::npos) << case_table({r}, {});
  EXPECT_EQ(nlohmann::json::parse(results_json({r}, {}))["cases"][0]["verdict"], "ok, 1 not met");
}

TEST(KnownMiss, IsReportedWithItsBound) {
  CaseResult r = good_case();
  missed(r, 1.1);
  missed(r, 1.3);
  EXPECT_EQ(tightest_check(r)->value, 1.3);  // a failure before a known miss
  const std::string table = check_table({r});
  EXPECT_NE(table.find("| not met, known: at most 1.2 |"), std::string::npos) << table;
  EXPECT_NE(table.find("| FAILED, known: at most 1.2"), std::string::npos) << table;
  EXPECT_NE(case_table({r}, {}).find("1 passed, 1 failed, 1 not met as known"), std::string::npos);
  const auto checks = nlohmann::json::parse(results_json({r}, {}))["cases"][0]["checks"];
  EXPECT_EQ(checks[0]["miss_cause"], "");
  EXPECT_TRUE(checks[0]["miss_bound"].is_null());
  EXPECT_EQ(checks[1]["verdict"], "not met");
  EXPECT_EQ(checks[1]["miss_bound"], 1.2);
  EXPECT_EQ(checks[1]["text"]["miss_bound"], "at most 1.2");
  EXPECT_EQ(checks[2]["verdict"], "FAILED");
  const std::string xml = junit_xml({r}, {});
  EXPECT_NE(
      xml.find(
          "<skipped message=\"not met: the front broadens; 1.1 against 1, error 10 %, tolerance 2 % (because); known: at most 1.2\"/>"),
      std::string::npos)
      << xml;
}

TEST(KnownMiss, IsOfThisProgramOnly) {
  const Scratch scratch;
  write_file(scratch.path / "README.md", "Physics.\n");
  const CaseEntry entry{"case", "Case", scratch.path, [](const CaseContext&, CaseResult& r) { missed(r, 1.1); }};
  EXPECT_TRUE(run_case_entry(entry, context_in(scratch.path)).passed());
  const Elsewhere source;
  EXPECT_FALSE(run_case_entry(entry, {Level::quick, 1, scratch.path, scratch.path, [](const std::string&) {}, &source}).passed());
}

TEST(Case, ThatThrowsFailsWithItsMessage) {
  const Scratch scratch;
  write_file(scratch.path / "README.md", "# Title\n\nThe physics in\ntwo lines.\n\nMore.\n");
  const CaseEntry entry{"throws", "Throws", scratch.path, [](const CaseContext&, CaseResult& r) {
                          r.check_absolute(Label::verification, "q", 0.0, 0.0, "", 0.0, "");
                          throw std::runtime_error("the solver stopped");
                        }};
  const CaseResult r = run_case_entry(entry, context_in(scratch.path));
  EXPECT_FALSE(r.passed());
  EXPECT_EQ(r.fault, "the solver stopped");
  EXPECT_EQ(r.physics, "The physics in two lines.");
  EXPECT_NE(case_table({r}, {}).find("1 passed, 1 failed"), std::string::npos);
}

TEST(Case, ThatAssertsNothingFails) {
  const Scratch scratch;
  write_file(scratch.path / "README.md", "Physics.\n");
  EXPECT_FALSE(run_case_entry({"empty", "Empty", scratch.path, [](const CaseContext&, CaseResult&) {}}, context_in(scratch.path)).passed());
}

TEST(Case, WithoutReadmeFails) {
  const Scratch scratch;
  const CaseEntry entry{"bare", "Bare", scratch.path,
                        [](const CaseContext&, CaseResult& r) { r.check_absolute(Label::verification, "q", 0.0, 0.0, "", 0.0, ""); }};
  EXPECT_FALSE(run_case_entry(entry, context_in(scratch.path)).passed());
}

TEST(CheckTable, NamesFailingCasesFirst) {
  const std::string table = check_table({good_case(), bad_case()});
  EXPECT_LT(table.find("bad "), table.find("good "));
  EXPECT_LT(table.find("pressure"), table.find("mass"));
  EXPECT_NE(table.find("| FAILED"), std::string::npos);
}

TEST(CaseTable, NamesFailingCasesFirstAndEndsWithTheCount) {
  const std::string table = case_table({good_case(), bad_case()}, {.threads = 2, .wall_time_s = 17.0});
  EXPECT_LT(table.find("bad "), table.find("good "));
  EXPECT_NE(table.find("1/2"), std::string::npos);
  EXPECT_NE(table.find("pressure"), std::string::npos);  // a failing check represents its case, not a passing one
  EXPECT_NE(table.find("time: 17 s with 2 threads; level quick may take 150 s"), std::string::npos);  // cases may run side by side
  EXPECT_NE(table.find("failing cases: bad\n"), std::string::npos);
  const std::string last = "2 passed, 1 failed\n";
  EXPECT_EQ(table.substr(table.size() - last.size()), last);
}

TEST(ToleranceUsed, IsAtMostOneExactlyWhereTheCheckHolds) {
  CaseResult r;
  const double values[] = {-2.0, 0.0, 0.5, 0.999, 1.0, 1.001, 1.5, 2.0, 2.001, nan};
  for (const double v : values)
    for (const double reference : {1.0, 2.0})
      for (const double tolerance : {0.0, 1e-3, 0.5, 1.0}) {
        r.check_relative(Label::verification, "q", v, reference, "", tolerance, "");
        r.check_absolute(Label::verification, "q", v, reference, "", tolerance, "");
        r.check_at_most(Label::verification, "q", v, reference, "", tolerance, "");
      }
  for (const Check& c : r.checks) EXPECT_EQ(tolerance_used(c) <= 1.0, c.passed) << c.value << ' ' << c.reference << ' ' << c.tolerance;
  EXPECT_EQ(tolerance_used(r.check_absolute(Label::verification, "q", 3.0, 1.0, "", 4.0, "")), 0.5);
  EXPECT_EQ(tolerance_used(r.check_at_most(Label::verification, "q", 1e-13, 1e-12, "", 0.0, "")), 0.1);  // a bound is used up by the value
}

TEST(TightestCheck, IsOneThatFailsIfThereIsOne) {
  CaseResult r = good_case();
  EXPECT_EQ(tightest_check(r)->quantity, "height");
  r.check_absolute(Label::verification, "nothing", nan, 0.0, "", 1.0, "");
  EXPECT_EQ(tightest_check(r)->quantity, "nothing");
  EXPECT_EQ(tightest_check(CaseResult{}), nullptr);
}

TEST(Errors, AreShownInTheirOwnMeasure) {
  const CaseResult good = good_case(), bad = bad_case();
  EXPECT_EQ(format_error(good.checks[0], 0.0123), "1.23 %");
  EXPECT_EQ(format_error(good.checks[0], 2e-13), "2e-13");
  EXPECT_EQ(format_error(bad.checks[0], 2.0), "2 Pa");
  EXPECT_EQ(format_value(0.0), "0");
  EXPECT_EQ(format_value(12345.678), "1.235e+04");
}

TEST(Junit, EscapesAndCounts) {
  CaseResult thrown;
  thrown.name = "thrown";
  thrown.fault = "a < b";
  const std::string xml = junit_xml({good_case(), bad_case(), thrown}, {});
  EXPECT_NE(xml.find("tests=\"4\" failures=\"1\" errors=\"1\""), std::string::npos);
  EXPECT_NE(xml.find("a &lt; b"), std::string::npos);
  EXPECT_NE(xml.find("<failure type="), std::string::npos);
}

TEST(Junit, IsWellFormedAndItsCountsAreThoseOfItsElements) {
  const Scratch scratch;
  CaseResult r = bad_case();
  r.check_absolute(Label::validation, "mass", 1.0, 2.0, "kg", 0.0, "a second of this name & <worse>\x01");
  CaseResult thrown = good_case();
  thrown.name = "thrown";
  thrown.fault = "stopped";
  write_results(scratch.path, {good_case(), r, thrown}, {.started = "2026-01-02T03:04:05Z"});
  write_file(scratch.path / "check.py", R"(
import sys, xml.etree.ElementTree as xml
root = xml.parse(sys.argv[1]).getroot()
assert root.tag == "testsuites"
names = set()
for suite in root:
    cases = suite.findall("testcase")
    assert int(suite.get("tests")) == len(cases) > 0
    assert int(suite.get("failures")) == len(suite.findall("testcase/failure"))
    assert int(suite.get("errors")) == len(suite.findall("testcase/error"))
    assert suite.get("timestamp") == "2026-01-02T03:04:05" and suite.get("hostname") and float(suite.get("time")) >= 0
    for case in cases:
        assert case.get("classname") == suite.get("name") and float(case.get("time")) >= 0
        names.add((case.get("classname"), case.get("name")))
total = sum(int(s.get("tests")) for s in root)
assert total == int(root.get("tests")) == len(names) == 6, (total, names)
assert int(root.get("failures")) == 2 and int(root.get("errors")) == 1
)");
  const std::string command =
      "/usr/bin/python3 '" + (scratch.path / "check.py").string() + "' '" + (scratch.path / "junit.xml").string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(Orders, ReadBackAsATable) {
  const Scratch scratch;
  CaseResult r = good_case();
  r.check_order(Label::verification, "order, of \"everything\"", 1.97, 1.8, 2.2, "");
  CaseResult thrown;
  thrown.name = "thrown";
  thrown.fault = "stopped, badly";
  write_results(scratch.path, {thrown, r, bad_case()}, {});
  const Table table = Table::read(scratch.path / "orders.csv");
  EXPECT_EQ(table.text("case"), (std::vector<std::string>{"bad", "bad", "good", "good", "thrown"}));
  EXPECT_EQ(table.text("quantity")[3], "order, of \"everything\"");
  EXPECT_EQ(table.numbers("order")[3], 1.97);
  EXPECT_TRUE(std::isnan(table.numbers("order")[2]));
  EXPECT_EQ(table.text("verdict"), (std::vector<std::string>{"FAILED", "ok", "ok", "ok", "FAILED"}));
  EXPECT_EQ(table.numbers("result")[0], 5.0);
}

TEST(Record, ReplacesTheRowsOfItsCasesAndKeepsTheOthers) {
  const Scratch scratch;
  RunInfo info{
      .level = Level::standard, .command = "mpm-validate run", .machine = "a machine, with comma", .started = "2026-01-02T03:04:05Z"};
  record_results(scratch.path, {good_case(), bad_case()}, info);
  info.level = Level::quick;
  record_results(scratch.path, {good_case()}, info);
  info.level = Level::standard;
  CaseResult again = bad_case();
  again.checks.pop_back();
  again.wall_time_s = 12.0;
  record_results(scratch.path, {again}, info);
  const Table data = Table::read(scratch.path / "data.csv");
  EXPECT_EQ(data.text("level"), (std::vector<std::string>{"quick", "standard", "standard"}));
  EXPECT_EQ(data.text("case"), (std::vector<std::string>{"good", "bad", "good"}));
  EXPECT_EQ(data.text("quantity"), (std::vector<std::string>{"height", "pressure", "height"}));
  const auto runs = recorded_cases(scratch.path);
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[1].name, "bad");
  EXPECT_EQ(runs[1].labels, "validation");
  EXPECT_EQ(runs[1].wall_time_s, 12.0);
  EXPECT_EQ(Table::read(scratch.path / "runs.csv").text("machine")[0], "a machine, with comma");
  EXPECT_NE(read_file(scratch.path / "SOURCE.md").find("level standard, `mpm-validate run`"), std::string::npos);
  EXPECT_TRUE(recorded_cases(scratch.path / "nowhere").empty());
}

TEST(Record, AppendsToTheHistory) {
  const Scratch scratch;
  RunInfo info{.level = Level::standard, .command = "mpm-validate run", .machine = "a machine", .started = "2026-01-02T03:04:05Z"};
  CaseResult r = good_case();
  r.checks.back().observed_order = 2.0;
  record_results(scratch.path, {r}, info);
  info.started = "2026-01-03T03:04:05Z";
  record_results(scratch.path, {bad_case()}, info);
  const Table history = Table::read(scratch.path / "history.csv");
  EXPECT_EQ(history.text("kind"), (std::vector<std::string>{"time", "check", "order", "time", "check", "check"}));
  EXPECT_EQ(history.text("case"), (std::vector<std::string>{"good", "good", "good", "bad", "bad", "bad"}));
  EXPECT_NEAR(history.numbers("value")[1], 0.5, 1e-3);  // an error of 1 %, a tolerance of 2 %
  EXPECT_EQ(history.numbers("value")[2], 2.0);
  EXPECT_EQ(history.text("verdict")[3], "FAILED");
}

TEST(Record, TellsATargetThatIsKnownNotToBeMetFromAFailure) {
  const Scratch scratch;
  CaseResult r;
  r.name = "known";
  r.check_relative(Label::verification, "met", 1.0, 1.0, "m", 0.02, "");
  r.check_relative(Label::verification, "not met", 1.05, 1.0, "m", 0.02, "").known_miss(1.06, "a cause");
  r.check_relative(Label::verification, "beyond its bound", 1.07, 1.0, "m", 0.02, "").known_miss(1.06, "a cause");
  record_results(scratch.path, {r}, {.machine = "a machine", .started = "2026-01-02T03:04:05Z"});
  const std::vector<std::string> verdicts = Table::read(scratch.path / "history.csv").text("verdict");
  EXPECT_EQ(std::vector(verdicts.begin() + 1, verdicts.begin() + 4), (std::vector<std::string>{"ok", "not met", "FAILED"}));
}

TEST(Record, OfAllCasesKeepsBiasAndSpread) {  // no case is registered in this program
  const Scratch scratch;
  CaseResult r = good_case();
  r.compare(Label::verification, "x", Quantity::force, 1.1, 1.0, "N");
  r.compare(Label::verification, "y", Quantity::force, 1.1, 1.0, "N");
  record_results(scratch.path, {r}, {.machine = "a machine", .started = "2026-01-02T03:04:05Z"});
  const Table history = Table::read(scratch.path / "history.csv");
  EXPECT_EQ(history.text("kind").back(), "spread");
  EXPECT_EQ(history.text("quantity").back(), "force, verification");
  EXPECT_EQ(history.numbers("value")[history.rows() - 2], 1.1);
}

TEST(ResultsJson, KeepsNumbersAndWritesNanAsNull) {
  CaseResult r = good_case();
  r.check_absolute(Label::verification, "broken", nan, 0.0, "m", 1.0, "");
  const auto j = nlohmann::json::parse(results_json({r, bad_case()}, {}));
  EXPECT_EQ(j["failed"], 2);
  EXPECT_EQ(j["passed"], 2);
  const auto& checks = j["cases"][0]["checks"];
  EXPECT_EQ(checks[0]["value"].get<double>(), 1.01);
  EXPECT_TRUE(checks[1]["value"].is_null());
  EXPECT_EQ(checks[1]["passed"], false);
  EXPECT_EQ(j["cases"][1]["title"], "A case that <fails> & says so");
}

TEST(WriteResults, LeavesPlotDataThatReadsBack) {
  const Scratch scratch;
  CaseResult r = good_case();
  r.plots.push_back({.id = "profile",
                     .title = "Profile",
                     .x_label = "z [m]",
                     .y_label = "p [Pa]",
                     .series = {{"a, \"quoted\"", {0.1, 0.2}, {1.0 / 3.0, 2.0}}},
                     .caption = ""});
  write_results(scratch.path, {r}, {});
  const Table table = Table::read(scratch.path / "data" / "good-profile.csv");
  EXPECT_EQ(table.numbers("y")[0], 1.0 / 3.0);
  EXPECT_TRUE(std::filesystem::exists(scratch.path / "junit.xml"));
  EXPECT_TRUE(std::filesystem::exists(scratch.path / "results.json"));
}

/// A small block above a floor and beside a mast.
FlowPicture block_picture(const std::filesystem::path& directory, FlowPicture picture) {
  Case c;
  c.material = HenckyElastic::Parameters{};
  c.numerics.cell_size = 0.25;
  c.bodies.push_back({BodySpec::Shape::box, Vec3(-1.0, -0.5, 0.0), Vec3(0.0, 0.5, 0.5), Vec3(2.0, 0.0, 0.0), Lattice::aligned});
  c.walls.push_back({});  // z = 0, upwards
  const CaseScene scene = make_scene(c);
  return flow_picture(directory, make_state(c, scene), scene, std::move(picture));
}

class FlowPictureOfAnObstacle : public ::testing::TestWithParam<ContactRule> {};
INSTANTIATE_TEST_SUITE_P(Rules, FlowPictureOfAnObstacle, ::testing::Values(ContactRule::nodal, ContactRule::surface),
                         [](const auto& rule) { return rule.param == ContactRule::nodal ? "nodal" : "surface"; });

TEST_P(FlowPictureOfAnObstacle, DrawsItsSectionWhateverItsShape) {
  const Scratch scratch;
  struct Mast {
    AnyShape shape;
    double from, to;  ///< along x, at y = 0
  };
  std::vector<Mast> masts;
  for (const auto& typical : mpm::testing::typical_shapes()) {
    const auto section = outline_of(typical.shape).section(0.0).value();
    masts.push_back({typical.shape, section.low, section.high});
  }
  const double turned = std::numbers::pi / 6.0, depth = 2.0 / std::cos(turned);  // of a wide plate, turned by 30 degrees
  const double plate = BoxShape{.width = 20.0, .depth = 2.0, .rotation = turned}.outline().section(0.0).value().low;
  masts.insert(masts.end(), {Mast{BoxShape{.width = 1.0, .depth = 2.0}, 0.0, 2.0}, Mast{CylinderShape{.width = 3.0}, 0.0, 3.0},
                             Mast{WedgeShape{.width = 1.0, .depth = 4.0}, 0.0, 4.0},
                             Mast{BoxShape{.width = 20.0, .depth = 2.0, .rotation = turned}, plate, plate + depth}});
  for (const Mast& mast : masts) {
    SCOPED_TRACE(mast.shape.index());
    Case c;
    c.material = HenckyElastic::Parameters{};
    c.numerics.contact = GetParam();
    c.bodies.push_back({BodySpec::Shape::box, Vec3(-2.0, -0.5, 0.0), Vec3(-1.0, 0.5, 0.5), Vec3::Zero()});
    c.obstacle = ObstacleSpec{.shape = mast.shape, .height = 1.5};
    const CaseScene scene = make_scene(c);
    const FlowPicture picture = flow_picture(scratch.path, make_state(c, scene), scene, {.id = "mast"});
    ASSERT_EQ(picture.boxes.size(), 1u);
    EXPECT_NEAR(picture.boxes[0][0], mast.from, 1e-12);
    EXPECT_NEAR(picture.boxes[0][2], mast.to, 1e-12);
    EXPECT_EQ(picture.boxes[0][3], 1.5);
  }
}

TEST(FlowPicture, KeepsTheParticlesOfTheSliceAndTheWallsThatCutIt) {
  const Scratch scratch;
  const FlowPicture all = block_picture(scratch.path, {.id = "all"});
  const FlowPicture slice = block_picture(scratch.path, {.id = "slice", .slice_half_width = 0.1});
  EXPECT_EQ(read_snapshot(all.snapshot, SnapshotKind::frame).particles.size(), 8u * 8u * 4u);
  EXPECT_EQ(read_snapshot(slice.snapshot, SnapshotKind::frame).particles.size(), 8u * 2u * 4u);
  ASSERT_EQ(slice.walls.size(), 1u);
  EXPECT_EQ(slice.walls[0], (std::array<double, 4>{0.0, 0.0, 0.0, 1.0}));
}

TEST(ResultsJson, NamesFilesOfTheReportRelativeToIt) {
  const Scratch scratch;
  CaseResult r = good_case();
  r.flows.push_back(block_picture(scratch.path / "cases" / "good", {.id = "block", .range = std::array{0.0, 3.0}}));
  write_results(scratch.path, {r}, {});
  const auto flow = nlohmann::json::parse(read_file(scratch.path / "results.json"))["cases"][0]["flows"][0];
  EXPECT_EQ(flow["snapshot"], "cases/good/flow-block/frames/00000.h5");
  EXPECT_EQ(flow["unit"], "m/s");
  EXPECT_EQ(flow["range"][1], 3.0);
  EXPECT_TRUE(flow["window_m"].is_null());
}

TEST(Report, IsDrawnFromTheResultsAsOneSelfContainedPage) {
  const Scratch scratch;
  if (std::system("/usr/bin/python3 -c 'import h5py, jinja2, matplotlib' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-h5py, python3-jinja2 or python3-matplotlib is not installed";
  CaseResult r = bad_case();
  r.physics = "Physics with `code` & <angle>.";
  r.compare(Label::validation, "force & <moment>", Quantity::force, 1.1, 1.0, "kN", 0.1);
  r.plots.push_back({.id = "p",
                     .title = "T",
                     .x_label = "x [m]",
                     .y_label = "y [Pa]",
                     .series = {{"ours", {1, 2, 4}, {1, nan, 4}, Series::Style::points}},
                     .caption = "",
                     .log_x = true,
                     .log_y = true});
  r.convergences.push_back({"height", "m", judge_convergence(std::array{0.4, 0.2, 0.1}, std::array{1.0, 1.2, 1.1}, 2.0)});
  r.flows.push_back(block_picture(scratch.path / "cases" / "bad", {.id = "speed", .title = "Block", .caption = "It moves."}));
  r.flows.push_back(block_picture(scratch.path / "cases" / "bad",
                                  {.id = "window", .field = FlowField::pressure, .window = std::array{10.0, 11.0, 0.0, 2.0}}));
  CaseResult thrown;
  thrown.name = "thrown";
  thrown.fault = "stopped";
  write_results(scratch.path, {good_case(), r, thrown}, {});
  ASSERT_EQ(std::system(("/usr/bin/python3 '" MPM_SOURCE_DIR "/scripts/validation_report.py' '" + scratch.path.string() + "'").c_str()), 0);
  const std::string page = read_file(scratch.path / "index.html");
  EXPECT_NE(page.find("2 passed, 2 failed"), std::string::npos);
  EXPECT_NE(page.find("<code>code</code> &amp; &lt;angle&gt;"), std::string::npos);
  EXPECT_NE(page.find(R"({"name":"ours","labels":["x [m]","y [Pa]"])"), std::string::npos) << "values of the plot's curve";
  EXPECT_NE(page.find(R"({"name":"simulation","labels":["cell size [m]","height [m]"])"), std::string::npos) << "of the grid study";
  EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
  EXPECT_NE(page.find("It moves. All particles at t = 0 s."), std::string::npos);
  EXPECT_NE(page.find("mpm-validate run --case bad --level quick"), std::string::npos);

  EXPECT_NE(page.find("oscillating"), std::string::npos);
  EXPECT_NE(page.find("Predicted against reference"), std::string::npos);
  EXPECT_NE(page.find("<g class=\"point\" tabindex=\"0\" data-text=\"A case that &lt;fails&gt; &amp; says so\nforce &amp; &lt;moment&gt;"),
            std::string::npos);
  for (const char* external : {"src=\"http", "href=\"http", "@import", "url(h", "url(/", "url('", "url(\""})
    EXPECT_EQ(page.find(external), std::string::npos) << external;
}

}  // namespace
}  // namespace mpm::validation
