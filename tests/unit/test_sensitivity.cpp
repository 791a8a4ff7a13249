#include "mpm/impact/sensitivity.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "mpm/error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

constexpr const char* head =
    "name,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,effective_friction,obstacle_width_m,obstacle_friction,"
    "obstacle_friction_ratio,cell_size_m,output.duration_s,numerics.slope_deg,runup_mean_m,runup_standard_error_m,"
    "pressure_height_mean_m,pressure_height_standard_error_m,force_mean_n.x,force_standard_error_n.x,predicted_runup_m,"
    "predicted_pressure_height_m\n";
// Two kinds of snow and a fluid. The base: friction 0.5 tan phi', dx 0.35, no slope.
constexpr const char* rows =
    "a,done,3,0.4,0,5,0.4,1.75,0.095,0.5,0.35,9,0,6,0.3,3,0.06,100,2,6,3\n"
    "a_mu,done,3,0.4,0,5,0.4,1.75,0.15,0.7894,0.35,9,0,5.4,0.27,3.3,0.066,110,2.2,6,3\n"
    "a_mur,done,3,0.4,0,5,0.4,1.75,0.0475,0.25,0.35,9,0,6.6,0.3,nan,nan,100,2,6,3\n"
    "a_slope,done,3,0.4,0,5,0.4,1.75,0.095,0.5,0.35,12,30,6.3,0.3,3,0.06,100,2,6,3\n"
    "b,done,5,0.8,0,5,0.8,1.75,0.1887,0.5000000000000001,0.35,10,0,8,0.4,4,0.1,200,4,10,4\n"
    "b_mu,done,5,0.8,0,5,0.8,1.75,0.15,0.3975,0.35,10,0,8.8,0.4,4,0.1,190,4,10,4\n"
    "b_mur,done,5,0.8,0,5,0.8,1.75,0.09435,0.25,0.35,10,0,10,0.4,4,0.1,180,4,10,4\n"
    "b_dx,done,5,0.8,0,5,0.8,1.75,0.1887,0.5,0.25,10,0,8.4,0.4,4,0.1,200,4,10,4\n"
    "b_none,done,5,0.8,0,5,0.8,1.75,0.1887,0.5,0.5,10,0,nan,nan,nan,nan,nan,nan,10,4\n"
    "water,done,3,0,0,5,0,1.75,0,nan,0.35,9,0,9,0.3,3,0.06,100,2,9,3\n"
    "water_mu,done,3,0,0,5,0,1.75,0.15,inf,0.35,9,0,7.2,0.3,3,0.06,100,2,9,3\n"
    "alone,done,1,0.4,0,5,0.4,1.75,0.15,0.7894,0.35,9,0,3,0.1,2,0.1,50,1,3,2\n"
    "later,to do,1,0.4,0,5,0.4,1.75,0.15,0.7894,0.35,9,0,nan,nan,nan,nan,nan,nan,3,2\n";

class Sensitivities : public ::testing::Test {
 protected:
  SensitivityStudy read(const std::string& text) {
    std::ofstream(directory_ / "results.csv") << text;
    return sensitivities(directory_ / "results.csv");
  }
  testing::TemporaryDirectory directory_;
};

const SensitivitySummary& summary(const SensitivityStudy& study, const std::string& choice, const std::string& value) {
  const auto found = std::ranges::find_if(study.summaries, [&](const auto& s) { return s.choice == choice && s.value == value; });
  EXPECT_NE(found, study.summaries.end()) << choice << " " << value;
  return found != study.summaries.end() ? *found : study.summaries.front();
}

TEST_F(Sensitivities, CompareEachRunWithTheBaseAtItsPoint) {
  const SensitivityStudy study = read(std::string(head) + rows);
  ASSERT_EQ(study.runs.size(), 10u);
  const Sensitivity& mu = study.runs[1];
  EXPECT_EQ(mu.choice, "obstacle_friction");
  EXPECT_EQ(mu.value, "0.15");
  EXPECT_DOUBLE_EQ(mu.runup.value, 0.9);
  EXPECT_NEAR(mu.runup.standard_error, 0.9 * std::hypot(0.05, 0.05), 1e-15);
  EXPECT_DOUBLE_EQ(mu.pressure_height.value, 1.1);
  EXPECT_DOUBLE_EQ(mu.force.value, 1.1);
  EXPECT_DOUBLE_EQ(mu.runup_to_published, 0.9);
  EXPECT_EQ(study.runs[0].choice, "") << "the base";
  EXPECT_EQ(study.runs[4].choice, "") << "its ratio carries a rounding error";
  EXPECT_EQ(study.runs[3].choice, "numerics.slope_deg") << "the duration is no choice";
}

TEST_F(Sensitivities, TellFrictionByWhatItsRowsHaveInCommon) {
  const SensitivityStudy study = read(std::string(head) + rows);
  const SensitivitySummary& mu = summary(study, "obstacle_friction", "0.15");
  EXPECT_EQ(mu.points, 3u);
  EXPECT_NEAR(mu.runup.mean, std::cbrt(0.9 * 1.1 * 0.8), 1e-14);
  EXPECT_DOUBLE_EQ(mu.runup.low, 0.8);
  EXPECT_DOUBLE_EQ(mu.runup.high, 1.1);
  const auto square = [](double x) { return std::log(x) * std::log(x); };
  EXPECT_NEAR(mu.runup_rmsle, std::sqrt((square(0.9) + square(0.88) + square(0.8)) / 3.0), 1e-14);
  EXPECT_NEAR(mu.base_runup_rmsle, std::sqrt(square(0.8) / 3.0), 1e-14);
  const SensitivitySummary& ratio = summary(study, "obstacle_friction_ratio", "0.25");
  EXPECT_EQ(ratio.points, 2u);
  EXPECT_DOUBLE_EQ(ratio.pressure_height.mean, 1.0) << "of the one that has a pressure height";
  EXPECT_EQ(summary(study, "", "").points, 3u) << "the fluid, which has no friction to take a share of, among them";
}

TEST_F(Sensitivities, SayWhatCouldNotBeCompared) {
  const SensitivityStudy study = read(std::string(head) + rows);
  ASSERT_EQ(study.notes.size(), 3u);
  EXPECT_NE(study.notes[0].find("b_none: no steady mean"), std::string::npos);
  EXPECT_NE(study.notes[1].find("alone: no run of the base"), std::string::npos);
  EXPECT_EQ(study.notes[2], "1 runs that are not done");
  EXPECT_THROW((void)read("name,status,froude_number\na,1\n"), IoError);
}

}  // namespace
}  // namespace mpm
