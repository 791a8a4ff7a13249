#include "validation/harness/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mpm/io/atomic_file.hpp"
#include "mpm/io/table.hpp"

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
  EXPECT_NE(summary_table({r}).find("1 passed, 1 failed"), std::string::npos);
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

TEST(SummaryTable, NamesFailingCasesFirstAndEndsWithTheCount) {
  const std::string table = summary_table({good_case(), bad_case()});
  EXPECT_LT(table.find("bad "), table.find("good "));
  EXPECT_LT(table.find("pressure"), table.find("mass"));
  EXPECT_NE(table.find("failing cases: bad\n"), std::string::npos);
  const std::string last = "2 passed, 1 failed\n";
  EXPECT_EQ(table.substr(table.size() - last.size()), last);
  EXPECT_NE(table.find("| FAILED"), std::string::npos);
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
  EXPECT_NE(xml.find("tests=\"4\" failures=\"2\""), std::string::npos);
  EXPECT_NE(xml.find("a &lt; b"), std::string::npos);
  EXPECT_NE(xml.find("<failure message="), std::string::npos);
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

TEST(Report, IsDrawnFromTheResultsAsOneSelfContainedPage) {
  const Scratch scratch;
  if (std::system("/usr/bin/python3 -c 'import jinja2, matplotlib' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-jinja2 or python3-matplotlib is not installed";
  CaseResult r = bad_case();
  r.physics = "Physics with `code` & <angle>.";
  r.plots.push_back({.id = "p",
                     .title = "T",
                     .x_label = "x [m]",
                     .y_label = "y [Pa]",
                     .series = {{"ours", {1, 2, 4}, {1, nan, 4}, Series::Style::points}},
                     .caption = "",
                     .log_x = true,
                     .log_y = true});
  r.studies.push_back({"height", "m", grid_study(std::array{0.4, 0.2, 0.1}, std::array{1.0, 1.2, 1.1}, 2.0)});
  CaseResult thrown;
  thrown.name = "thrown";
  thrown.fault = "stopped";
  write_results(scratch.path, {good_case(), r, thrown}, {});
  ASSERT_EQ(std::system(("/usr/bin/python3 '" MPM_SOURCE_DIR "/scripts/validation_report.py' '" + scratch.path.string() + "'").c_str()), 0);
  const std::string page = read_file(scratch.path / "index.html");
  EXPECT_NE(page.find("2 passed, 2 failed"), std::string::npos);
  EXPECT_NE(page.find("<code>code</code> &amp; &lt;angle&gt;"), std::string::npos);
  EXPECT_NE(page.find("data:image/svg+xml;base64,"), std::string::npos);
  EXPECT_NE(page.find("oscillating"), std::string::npos);
  for (const char* external : {"src=\"http", "href=\"http", "@import", "url("})
    EXPECT_EQ(page.find(external), std::string::npos) << external;
}

}  // namespace
}  // namespace mpm::validation
