/// `mpm predict` and `mpm compare` as a user runs them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "libmpm/io/csv.hpp"
#include "support/command.hpp"
#include "support/reference_csv.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// @returns with standard output and messages together
testing::Outcome run(const std::string& arguments) {
  const testing::TemporaryDirectory here;
  return testing::run_command("'" MPM_APP "' 2>&1 " + arguments, here.path(), here.path());
}

std::string quoted(const std::filesystem::path& path) { return fmt::format("'{}'", path.string()); }

TEST(Predict, NamesWhatItTookWithoutBeingAsked) {
  const auto outcome = run("predict --froude 3 --flow-height 2");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("not given, so taken: --critical-state-slope 0.4, --cohesion-beta 0, --obstacle-width 1.75, --hardening-xi 5"),
            std::string::npos)
      << outcome.out;
}

TEST(Predict, SaysWhatItExtrapolates) {
  const auto outcome = run("predict --froude 20 --critical-state-slope 3 --flow-height 1.75");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("extrapolated: the equations were not fitted to Fr = 20 (0.1 to 7), M' = 3 (0 to 2.3)"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(run("predict --froude 3").out.find("extrapolated"), std::string::npos);
}

TEST(Predict, WritesEveryCombinationAsCsvThatMatchesTheReference) {
  const testing::TemporaryDirectory directory;
  const auto outcome =
      run("predict --froude 0.1,0.3,1,2,3,5,7 --critical-state-slope 0,0.4,0.8 --csv > " + quoted(directory / "table.csv"));
  ASSERT_EQ(outcome.code, 0) << outcome.out;
  const Table table = Table::read(directory / "table.csv");
  ASSERT_EQ(table.rows(), 21u);
  const auto froude = table.numbers("froude_number"), friction = table.numbers("effective_friction");
  const auto runup = table.numbers("runup_over_flow_height"), height = table.numbers("pressure_height_over_flow_height");
  int compared = 0;
  for (const auto& row : testing::read_reference("paper_semiempirical_predictions")) {
    for (std::size_t i = 0; i < table.rows(); ++i) {
      // Without cohesion M' = M; the Froude number passes through the velocity and returns with round-off.
      if (friction[i] != testing::number(row, "Mprime") || std::abs(froude[i] - testing::number(row, "Fr")) > 1e-12) continue;
      EXPECT_NEAR(runup[i] / testing::number(row, "hr_over_H_A"), 1.0, 1e-9);  // digits of the reference
      EXPECT_NEAR(height[i] / testing::number(row, "hp_over_H_A"), 1.0, 1e-9);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 21);
}

TEST(Predict, PrintsOneCaseAsAListWithUnits) {
  const auto outcome = run("predict --froude 3 --critical-state-slope 0.4");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("6.6078 m    run-up"), std::string::npos) << outcome.out;
}

TEST(Predict, RefusesBadInputWithExitCodeTwo) {
  for (const char* arguments : {"--cohesion-beta 1", "--froude -1", "--froude abc", "--froude nan", "--velocity 3 --froude 1",
                                "--flow-height 0", "--hardening-xi 0", "--poisson-ratio 0.5", "--no-such-option 1"}) {
    const auto outcome = run(std::string("predict ") + arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.out;
    EXPECT_FALSE(outcome.out.empty());
  }
}

class Compare : public ::testing::Test {
 protected:
  /// A result folder with a mean of 4.0 m known to 0.1 m, and steps, which have no uncertainty.
  std::string folder(const std::string& name, const std::string& hash, const std::string& runup, int steps = 100) {
    std::filesystem::create_directory(directory_ / name);
    std::ofstream(directory_ / name / "results.json")
        << "{\"case_hash\": \"" << hash << "\", \"commit\": \"abc\", \"wall_time_s\": " << name.size() << ", \"steps\": " << steps
        << ", \"runup_mean_m\": " << runup << ", \"runup_standard_error_m\": 0.1, \"force_mean_n\": [1e5, 0.0, null]}";
    return quoted(directory_ / name);
  }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::filesystem::create_directory(directory_ / name);
    std::ofstream(directory_ / name / "results.json") << text;
    return directory_ / name;
  }

 private:
  testing::TemporaryDirectory directory_;
};

TEST_F(Compare, JudgesMeansByTheirCombinedStandardError) {
  // 2 sqrt(0.1^2 + 0.1^2) = 0.283
  const auto a = folder("a", "1", "4.0");
  EXPECT_EQ(run("compare " + a + " " + folder("near", "2", "4.28")).code, 0);
  const auto far = run("compare " + a + " " + folder("far", "2", "4.29"));
  EXPECT_EQ(far.code, 1);
  EXPECT_NE(far.out.find("DIFFERS"), std::string::npos);
  EXPECT_EQ(run("compare " + a + " " + folder("unsteady", "2", "null")).code, 1) << "a mean on one side only";
}

TEST_F(Compare, DemandsIdenticalQuantitiesOfTheSameRunOnly) {
  const auto a = folder("a", "1", "4.0", 100);
  EXPECT_EQ(run("compare " + a + " " + folder("same", "1", "4.0", 100)).code, 0) << "wall time may differ";
  EXPECT_EQ(run("compare " + a + " " + folder("changed", "1", "4.0", 101)).code, 1);
  EXPECT_EQ(run("compare " + a + " " + folder("other", "2", "4.0", 101)).code, 0) << "another case has other steps";
}

TEST_F(Compare, FindsTwoRunsOfOneCaseIdentical) {
  const testing::TemporaryDirectory here;
  std::ofstream(here / "case.toml") << R"(
title = "a small block"
[material]
model = "hencky_elastic"
[[body]]
shape = "box"
min_m = [0.0, 0.0, 0.0]
max_m = [0.5, 0.5, 0.5]
velocity_m_s = [1.0, 0.0, 0.0]
[domain]
min_m = [-2.0, -2.0, -2.0]
max_m = [2.0, 2.0, 2.0]
[numerics]
cell_size_m = 0.25
[output]
duration_s = 0.02
)";
  for (const char* folder : {"a", "b"}) {
    const auto outcome = run("run " + quoted(here / "case.toml") + " --threads 1 --out " + quoted(here / folder));
    ASSERT_EQ(outcome.code, 0) << outcome.out;
  }
  const auto same = run("compare " + quoted(here / "a") + " " + quoted(here / "b"));
  EXPECT_EQ(same.code, 0) << same.out;
  EXPECT_NE(same.out.find("steps"), std::string::npos) << same.out;
  EXPECT_EQ(same.out.find("solver_time_s"), std::string::npos) << same.out;
  // frames are other samples than the run's own: nothing has to be identical
  ASSERT_EQ(run("post " + quoted(here / "a") + " --no-pictures").code, 0);
  ASSERT_EQ(run("post " + quoted(here / "b") + " --no-pictures").code, 0);
  EXPECT_EQ(run("compare " + quoted(here / "a") + " " + quoted(here / "a/post")).code, 2);
  EXPECT_EQ(run("compare " + quoted(here / "a") + " " + quoted(here / "a/post") + " --tolerance 1e-3").code, 0);
  EXPECT_EQ(run("compare " + quoted(here / "a/post") + " " + quoted(here / "b/post")).code, 0);
  const auto shorter = run("run " + quoted(here / "case.toml") + " --set numerics.cfl=0.2 --out " + quoted(here / "c"));
  ASSERT_EQ(shorter.code, 0) << shorter.out;
  EXPECT_EQ(run("compare " + quoted(here / "a") + " " + quoted(here / "c") + " --tolerance 1e-3").code, 1) << "other steps";
}

TEST_F(Compare, ToleranceJudgesEveryQuantity) {
  const auto a = folder("a", "1", "4.0", 100), b = folder("b", "2", "4.0", 104);
  EXPECT_EQ(run("compare " + a + " " + b + " --tolerance 0.05").code, 0);
  EXPECT_EQ(run("compare " + a + " " + b + " --tolerance 0.03").code, 1);
  EXPECT_EQ(run("compare " + a + " " + b + " --tolerance -1").code, 2);
}

TEST_F(Compare, NeverPassesWhereNothingCouldBeJudged) {
  const auto a = write("a", R"({"case_hash": "1", "steps": 1})"), b = write("b", R"({"case_hash": "2", "steps": 2})");
  const auto outcome = run("compare " + quoted(a) + " " + quoted(b));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.out.find("--tolerance"), std::string::npos) << outcome.out;
}

TEST_F(Compare, PrintsNoNegativeZero) {
  const auto a = write("a", R"({"case_hash": "1", "runup_mean_m": -0.0, "force_mean_n": [1e5, -0.0, 0.0]})"),
             b = write("b", R"({"case_hash": "2", "runup_mean_m": 0.0, "force_mean_n": [1e5, 0.0, -0.0]})");
  const std::regex negative_zero("(^|[ ,])-0(\\.0*)?([ ,\n]|$)");
  for (const char* option : {"", " --csv"}) {
    const auto outcome = run("compare " + quoted(a) + " " + quoted(b) + " --tolerance 0.1" + option);
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    EXPECT_NE(outcome.out.find("runup_mean_m"), std::string::npos) << outcome.out;
    EXPECT_FALSE(std::regex_search(outcome.out, negative_zero)) << outcome.out;
  }
}

TEST_F(Compare, ReportsUnreadableResultsWithExitCodeFour) {
  const auto a = folder("a", "1", "4.0");
  EXPECT_EQ(run("compare " + a + " " + quoted(write("torn", R"({"case_hash": "1", "ste)"))).code, 4);
  EXPECT_EQ(run("compare " + a + " " + quoted(write("list", "[1, 2]"))).code, 4);
  const auto missing = run("compare " + a + " " + a + "-missing");
  EXPECT_EQ(missing.code, 4);
  EXPECT_NE(missing.out.find("results.json"), std::string::npos) << missing.out;
  const testing::TemporaryDirectory interrupted;
  std::ofstream(interrupted.path() / "checkpoint.h5") << "";
  const auto begun = run("compare " + a + " " + quoted(interrupted.path()));
  EXPECT_EQ(begun.code, 4);
  EXPECT_NE(begun.out.find("the run has not ended"), std::string::npos) << begun.out;
  EXPECT_NE(begun.out.find("--resume"), std::string::npos) << begun.out;
}

}  // namespace
}  // namespace mpm
