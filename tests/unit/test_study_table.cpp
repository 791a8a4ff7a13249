#include "mpm/impact/study_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "support/io_error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

class StudyTables : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(directory_ / name) << text;
    return directory_ / name;
  }
  StudyTable read(const std::string& text, std::initializer_list<const char*> conditions = {}) {
    const std::vector<std::filesystem::path> files{write("results.csv", text)};
    std::vector<RowFilter> filters;
    for (const char* condition : conditions) filters.emplace_back(condition);
    return read_study_table(files, filters);
  }
  testing::TemporaryDirectory directory_;
};

constexpr const char* table = R"(# plan: quick
# machine: two cores
run,conveyor.froude_number,material.critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,obstacle.width_m,cell_size_m,steady,status,runup_mean_m,runup_standard_error_m,runup_peak_m,pressure_height_mean_m
a,1,0.4,0.15,5,1.75,1.75,0.25,true,done,3.5,0.35,7,2.625
b,3,0.4,0.15,0.5,1.75,3.5,0.5,true,done,7,0.7,8.75,
c,5,0.8,0,5,1.75,1.75,0.25,false,done,nan,nan,9,nan
d,7,0.8,0,5,1.75,1.75,0.25,,unstable,,,,
)";

TEST_F(StudyTables, HeightsAreOverTheFlowHeightAndInputsAreFoundByTheEndOfTheirName) {
  const StudyTable t = read(table);
  ASSERT_EQ(t.runs.size(), 2u);
  EXPECT_EQ(t.rows, 4u);
  const StudyRun& a = t.runs[0];
  EXPECT_EQ(a.folder, directory_ / "a");
  EXPECT_EQ(a.froude, 1.0);
  EXPECT_EQ(a.effective_friction, effective_friction(0.4, 0.15));
  EXPECT_EQ(a.hardening_xi, 5.0);
  EXPECT_EQ(a.velocity, flow_velocity(1.0, 1.75));
  EXPECT_EQ(a.runup, 2.0);
  EXPECT_DOUBLE_EQ(a.runup_error, 0.2);
  EXPECT_EQ(a.runup_peak, 4.0);
  EXPECT_EQ(a.pressure_height, 1.5);
  EXPECT_TRUE(std::isnan(a.pressure_height_error));  // no such column
  EXPECT_TRUE(a.reference_width());
  EXPECT_FALSE(t.runs[1].reference_width());
  EXPECT_EQ(t.runs[1].relative_width(), 2.0);
  EXPECT_TRUE(std::isnan(t.runs[1].pressure_height));
  EXPECT_EQ(t.provenance, (std::vector<std::string>{"plan: quick", "machine: two cores"}));
}

TEST_F(StudyTables, RowsWithoutAMeanAreCountedByReason) {
  const StudyTable t = read(table, {"hardening_xi=5"});
  using Counts = std::vector<std::pair<std::string, std::size_t>>;
  EXPECT_EQ(t.left_out, (Counts{{"filter hardening_xi=5", 1}, {"no steady span", 1}, {"status: unstable", 1}}));
  ASSERT_EQ(t.runs.size(), 1u);
}

TEST_F(StudyTables, SayWhatVariesAndIsNotInTheEquations) {
  const StudyTable t = read(table);
  ASSERT_EQ(t.cautions.size(), 1u);
  EXPECT_NE(t.cautions[0].find("cell_size_m varies (0.25, 0.5)"), std::string::npos) << t.cautions[0];
  EXPECT_TRUE(read(table, {"cell_size_m=0.25"}).cautions.empty());
}

TEST_F(StudyTables, FrictionOfTheMastThatFollowsTheSnowsOwnIsOneChoice) {
  const std::string head =
      "froude_number,effective_friction,hardening_xi,flow_height_m,obstacle_friction,obstacle_friction_ratio,runup_mean_m,"
      "pressure_height_mean_m\n";
  EXPECT_TRUE(read(head + "1,0,5,2,0,nan,4,3\n1,0.4,5,2,0.095,0.5,4,3\n3,0.8,5,2,0.189,0.50000000000000011,4,3\n").cautions.empty());
  EXPECT_EQ(read(head + "1,0,5,2,0,nan,4,3\n1,0.4,5,2,0.095,0.5,4,3\n3,0.8,5,2,0.15,0.397,4,3\n").cautions.size(), 1u);
}

TEST_F(StudyTables, TakeVelocityAndEffectiveFrictionInPlaceOfFroudeNumberAndRheology) {
  const StudyTable t =
      read("velocity_m_s,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n6,0.5,5,2,4,3\n");
  ASSERT_EQ(t.runs.size(), 1u);
  EXPECT_EQ(t.runs[0].froude, froude_number(6.0, 2.0));
  EXPECT_EQ(t.runs[0].effective_friction, 0.5);
  EXPECT_TRUE(std::isnan(t.runs[0].critical_state_slope));
  EXPECT_TRUE(t.runs[0].reference_width());  // no width in the table
  EXPECT_TRUE(t.runs[0].folder.empty());
  EXPECT_TRUE(t.provenance.empty());
}

TEST_F(StudyTables, SayWhichProgramsComputedTheRuns) {
  const StudyTable t = read(
      "version,commit,froude_number,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n"
      "0.1.0,abc,1,0.5,5,2,4,3\n0.1.0,def,3,0.5,5,2,4,3\n0.1.0,abc,5,0.5,5,2,nan,nan\n,,7,0.5,5,2,nan,nan\n");
  EXPECT_EQ(t.provenance, (std::vector<std::string>{"2 runs by version 0.1.0, commit abc", "1 runs by version 0.1.0, commit def"}));
}

TEST_F(StudyTables, SayHowACampaignWasComputed) {
  write("runs.csv", "name,threads,wall_time_s,instruction_set,compiler\na,1,1800,AVX2,\"gcc, 12\"\nb,1,5400,AVX2,\"gcc, 12\"\nc,,,,\n");
  const StudyTable t = read(table);
  ASSERT_EQ(t.provenance.size(), 4u);  // two comments, the machine, the time
  EXPECT_EQ(t.provenance[2], "2 runs with 1 thread(s) a run, AVX2, gcc, 12");
  EXPECT_EQ(t.provenance[3], "2.0 h of wall time, summed over the runs");
  EXPECT_EQ(t.files, (std::vector<std::string>{(directory_ / "results.csv").string()}));
}

TEST_F(StudyTables, OfSeveralFilesArePutTogether) {
  const std::vector<std::filesystem::path> files{write("one.csv", table), write("two.csv", table)};
  EXPECT_EQ(read_study_table(files).runs.size(), 4u);
}

TEST_F(StudyTables, RefuseWhatTheyCannotRead) {
  EXPECT_THROW((void)read("run,runup_mean_m\na,1\n"), IoError);  // columns are missing
  EXPECT_THROW((void)read(table, {"no_such_column=1"}), ConfigError);
  EXPECT_THROW((void)read(table, {"status<3"}), ConfigError);
  EXPECT_THROW(
      (void)read("a.froude_number,b.froude_number,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n"),
      IoError);  // which of the two?
}

TEST(RowFilter, ComparesNumbersAsNumbersAndTextAsText) {
  EXPECT_TRUE(RowFilter("x=0.5,5").keeps("5.0"));
  EXPECT_TRUE(RowFilter("x = 0.5, 5").keeps("0.5"));
  EXPECT_FALSE(RowFilter("x=0.5,5").keeps("1.5"));
  EXPECT_FALSE(RowFilter("x!=0.5,5").keeps("5"));
  EXPECT_TRUE(RowFilter("x<=3").keeps("3"));
  EXPECT_FALSE(RowFilter("x<3").keeps("3"));
  EXPECT_TRUE(RowFilter("x>2.5").keeps("3"));
  EXPECT_FALSE(RowFilter("x>=3").keeps("2.9"));
  EXPECT_FALSE(RowFilter("x>=3").keeps(""));
  EXPECT_TRUE(RowFilter("transfer=apic").keeps("apic"));
  EXPECT_EQ(RowFilter("transfer=apic").column(), "transfer");
}

TEST(RowFilter, RefusesWhatIsNoCondition) {
  for (const char* text : {"", "x", "=3", "x==3", "x<a", "x<1,2", "x=>3"}) {
    EXPECT_THROW((void)RowFilter(text), ConfigError) << text;
  }
}

}  // namespace
}  // namespace mpm
