/// `mpm fit` and `mpm study` as a user runs them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "mpm/impact/regression.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/io/table.hpp"
#include "support/command.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::content;
using testing::Outcome;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A campaign's table on the paper's grid: heights by Eqs. 7-10 with known coefficients and a reproducible scatter of 8 %.
std::string synthetic_table(const HeightCoefficients& runup, const HeightCoefficients& pressure, double scatter) {
  std::string text =
      "# plan: synthetic\n"
      "name,run,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,obstacle_width_m,cell_size_m,steady,"
      "runup_mean_m,runup_standard_error_m,runup_peak_m,pressure_height_mean_m\n";
  int i = 0;
  for (const double xi : {0.05, 0.5, 5.0}) {
    for (const double froude : {0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0}) {
      for (const double slope : {0.0, 0.4, 0.8, 1.2}) {
        for (const double beta : {0.0, 0.15, 0.3, 0.45}) {
          ++i;
          const HeightSample s{effective_friction(slope, beta), froude, 1.0};
          const double noise = std::exp(scatter * std::sin(7.0 * i));
          const std::string name = fmt::format("r{}", i);
          text += fmt::format("{},runs/{},", name, name);
          if (i % 50 == 0) {  // one in fifty has no steady span
            text += fmt::format("done,{},{},{},{},1.75,1.75,0.25,0,nan,nan,9,nan\n", froude, slope, beta, xi);
          } else {
            text += fmt::format("done,{},{},{},{},1.75,1.75,0.25,1,{},0.02,9,{}\n", froude, slope, beta, xi,
                                1.75 * relative_height(s, runup) * noise, 1.75 * relative_height(s, pressure) * noise);
          }
        }
      }
    }
  }
  return text;
}

class Fit : public ::testing::Test {
 protected:
  Outcome mpm(const std::string& arguments) const {
    return testing::run_command(std::string(MPM_APP) + " " + arguments, directory_.path(), directory_.path());
  }
  void write_table(double scatter) const { std::ofstream(directory_ / "results.csv") << synthetic_table(runup_, pressure_, scatter); }
  const testing::TemporaryDirectory directory_;
  const HeightCoefficients runup_{0.8, 1.4}, pressure_{0.6, 1.1, 1.7};
};

TEST_F(Fit, RecoversTheCoefficientsOfASyntheticTable) {
  write_table(0.0);
  const Outcome out = mpm("fit results.csv --json");
  ASSERT_EQ(out.code, 0) << out.err;
  const auto json = nlohmann::json::parse(out.out);
  EXPECT_EQ(json["rows"], 336);
  EXPECT_EQ(json["runs"], 330);
  EXPECT_EQ(json["left_out"][0]["reason"], "no steady span");
  EXPECT_EQ(json["left_out"][0]["rows"], 6);
  ASSERT_EQ(json["fits"].size(), 4u);  // two sets of two equations
  for (const auto& fit : json["fits"]) {
    const bool runup = fit["equation"] == "runup";
    const HeightCoefficients& truth = runup ? runup_ : pressure_;
    for (const auto& c : fit["coefficients"]) {
      const std::string name = c["parameter"];
      const double value = name[0] == 'F' ? truth.saturation_froude : name[1] == '_' ? truth.k : truth.kappa;
      EXPECT_NEAR(c["value"].get<double>(), value, 1e-8) << name;
    }
    EXPECT_NEAR(fit["scores_of_fitted"]["rmsle"].get<double>(), 0.0, 1e-8);
    EXPECT_GT(fit["scores_of_published"]["rmsle"].get<double>(), 0.01);
  }
}

TEST_F(Fit, PrintsTheLayoutOfThePapersTables) {
  write_table(0.08);
  const Outcome out = mpm("fit results.csv --breakdown");
  ASSERT_EQ(out.code, 0) << out.err;
  for (const char* part : {"k_r (-)",
                           "kappa_r (-)",
                           "k_p (-)",
                           "Fr_sat (-)",
                           "kappa_p (-)",
                           "rel. std. error",
                           "t-statistic",
                           "p-value",
                           "R2_log",
                           "NRMSE",
                           "RMSLE",
                           "Bias_x",
                           "Frac_10",
                           "Frac_25",
                           "set 'narrow'",
                           "set 'wide'",
                           "left out: 6 (no steady span)",
                           "0.9468",
                           "1.5745",
                           "0.5277",
                           "1.3072",
                           "1.5380",
                           "froude_number",
                           "effective_friction",
                           "hardening_xi",
                           "no run in between"}) {
    EXPECT_TRUE(contains(out.out, part)) << part << "\n" << out.out;
  }
}

TEST_F(Fit, WritesItsTablesAsCsv) {
  write_table(0.08);
  ASSERT_EQ(mpm("fit results.csv --csv coefficients").code, 0);
  std::filesystem::rename(directory_ / "out.txt", directory_ / "coefficients.csv");
  ASSERT_EQ(mpm("fit results.csv --csv scores").code, 0);
  std::filesystem::rename(directory_ / "out.txt", directory_ / "scores.csv");
  const Table scores = Table::read(directory_ / "scores.csv");
  // The groups' squared errors make up those of the whole: RMSLE^2 n summed over the Froude numbers.
  const auto rmsle = scores.numbers("rmsle"), runs = scores.numbers("runs");
  const auto equation = scores.text("equation"), set = scores.text("fitting_set"), coefficients = scores.text("coefficients"),
             xi = scores.text("hardening_xi"), group = scores.text("group");
  double whole = 0.0, parts = 0.0;
  for (std::size_t i = 0; i < scores.rows(); ++i) {
    if (equation[i] != "runup" || set[i] != "narrow" || coefficients[i] != "fitted" || !xi[i].empty()) continue;
    if (group[i].empty()) whole += runs[i] * rmsle[i] * rmsle[i];
    if (group[i] == "froude_number") parts += runs[i] * rmsle[i] * rmsle[i];
  }
  EXPECT_GT(whole, 0.0);
  EXPECT_NEAR(parts / whole, 1.0, 1e-12);
}

TEST_F(Fit, FilterChoosesRows) {
  write_table(0.08);
  const Outcome out = mpm("fit results.csv --filter hardening_xi=5 --filter 'froude_number<=5' --json");
  ASSERT_EQ(out.code, 0) << out.err;
  const auto json = nlohmann::json::parse(out.out);
  int without_mean = 0;
  for (const auto& left_out : json["left_out"]) without_mean += left_out["reason"] == "no steady span" ? left_out["rows"].get<int>() : 0;
  EXPECT_EQ(json["fits"][0]["runs"].get<int>() + without_mean, 96);  // 6 Froude numbers, 16 rheologies
}

TEST_F(Fit, SaysWhatIsWrong) {
  write_table(0.08);
  EXPECT_EQ(mpm("fit no_such.csv").code, 4);
  EXPECT_EQ(mpm("fit results.csv --filter hardening_xi").code, 2);
  EXPECT_EQ(mpm("fit results.csv --csv nonsense").code, 2);
  const Outcome none = mpm("fit results.csv --filter hardening_xi=9");
  EXPECT_EQ(none.code, 2);
  EXPECT_TRUE(contains(none.err, "336 filter hardening_xi=9")) << none.err;
  const Outcome few = mpm("fit results.csv --filter 'critical_state_slope=0'");
  EXPECT_EQ(few.code, 2);
  EXPECT_TRUE(contains(few.err, "k needs runs with M' > 0")) << few.err;
  std::ofstream(directory_ / "short.csv") << "run,runup_mean_m\na,1\n";
  const Outcome columns = mpm("fit short.csv");
  EXPECT_EQ(columns.code, 4);
  EXPECT_TRUE(contains(columns.err, "critical_state_slope")) << columns.err;
}

TEST_F(Fit, StudyWritesTheNumbersOfEveryFigure) {
  write_table(0.08);
  std::filesystem::create_directories(directory_ / "runs/r1");
  std::ofstream(directory_ / "runs/r1/series.csv") << "time_s,runup_m,pressure_height_m\n0,0,nan\n1,3.5,1.75\n2,7,3.5\n";
  const Outcome out = mpm("study results.csv --out study");
  ASSERT_EQ(out.code, 0) << out.err;
  EXPECT_TRUE(contains(out.out, "guideline lambda = 1.5, xi = 5")) << out.out;
  EXPECT_TRUE(contains(out.out, "xi = 0.5 did not keep its last state")) << out.out;
  const auto table = [&](const std::string& name) { return Table::read(directory_ / "study" / (name + ".csv")); };
  EXPECT_EQ(table("points").rows(), 330u);
  EXPECT_EQ(table("decomposition").rows(), 28u);    // 7 Froude numbers, 4 links
  EXPECT_EQ(table("guideline_minima").rows(), 6u);  // 2 lambdas, 3 xis
  EXPECT_EQ(table("height_curves").rows() % 7, 0u);
  EXPECT_EQ(table("width_factors").rows(), 0u);
  const Table envelopes = table("envelopes");
  ASSERT_EQ(envelopes.rows(), 3u);
  EXPECT_EQ(envelopes.numbers("runup_high")[2], 4.0);
  EXPECT_EQ(table("height_choices").rows(), 3u);
  EXPECT_EQ(table("compaction").rows(), 0u);  // the table does not say how dense the snow became
  for (const char* name : {"coefficients", "scores", "factor_curves", "effective_friction", "guideline", "sections", "spreads"}) {
    EXPECT_NO_THROW((void)table(name)) << name;
  }
  EXPECT_TRUE(nlohmann::json::accept(content(directory_ / "study/fit.json")));

  // The page: every figure is there or says what it lacks, and the page needs no other file.
  const Outcome drawn = testing::run_command("/usr/bin/python3 '" MPM_SOURCE_DIR "/validation/study/study_page.py' page/index.html study",
                                             directory_.path(), directory_.path());
  ASSERT_EQ(drawn.code, 0) << drawn.err;
  const std::string page = content(directory_ / "page/index.html");
  for (const char* part : {"id=\"tableA1\"",
                           "id=\"tableA2\"",
                           "id=\"fig1\"",
                           "id=\"fig3\"",
                           "id=\"fig4\"",
                           "id=\"fig5\"",
                           "id=\"fig6\"",
                           "id=\"fig7\"",
                           "id=\"fig8\"",
                           "id=\"fig9\"",
                           "id=\"fig10\"",
                           "id=\"figA2\"",
                           "id=\"figA3\"",
                           "id=\"figA4\"",
                           "id=\"figA5\"",
                           "id=\"compaction\"",
                           "id=\"mast-height\"",
                           "no table of the width study",
                           "Fr = 5: no time histories",
                           "plan: synthetic"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  EXPECT_FALSE(contains(page, "src=\"http"));
}

}  // namespace
}  // namespace mpm
