/// [conveyor] inflow_csv: a table of a path model as the inflow of a case.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;

class InflowTables : public ::testing::Test {
 protected:
  /// The case with this table beside it. @param more  further keys of [conveyor]
  Case read(const std::string& table, const std::string& more = "") {
    std::ofstream(directory_ / "flow.csv") << table;
    std::ofstream(directory_ / "case.toml")
        << "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0\nhardening_xi = 5\ndensity_kg_m3 = 200\n"
           "[conveyor]\ninflow_csv = \"flow.csv\"\n" +
               more + "[obstacle]\n[output]\nduration_s = 4\n";
    return read_case(directory_ / "case.toml");
  }
  std::string message(const std::string& table, const std::string& more = "") {
    try {
      (void)read(table, more);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  testing::TemporaryDirectory directory_;
};

constexpr const char* surge = "time_s,depth_m,velocity_m_s,density_kg_m3\n0,0.5,8,200\n1,2,14,250\n3,1.5,10,200\n";

TEST_F(InflowTables, BecomeRowsOfTheInflow) {
  const Case c = read(surge);
  ASSERT_EQ(c.conveyor->inflow.size(), 3U);
  EXPECT_EQ(c.conveyor->inflow[1].time, 1.0);
  EXPECT_EQ(c.conveyor->inflow[1].velocity, 14.0);
  EXPECT_EQ(c.conveyor->inflow[1].flow_height, 2.0);
  EXPECT_EQ(c.conveyor->inflow[1].density_ratio, 1.25);
}

TEST_F(InflowTables, GiveTheSpeedAndHeightOfTheStrongestRowUnlessTheCaseDoes) {
  EXPECT_EQ(read(surge).conveyor->velocity, 14.0);
  EXPECT_EQ(read(surge).conveyor->flow_height, 2.0);
  const Case own = read(surge, "velocity_m_s = 9\nflow_height_m = 1\n");
  EXPECT_EQ(own.conveyor->velocity, 9.0);
  EXPECT_EQ(own.conveyor->flow_height, 1.0);
}

TEST_F(InflowTables, WithAMisspeltDensityAreRefused) {
  for (const std::string name : {"densiy_kg_m3", "density", "density_kgm3"}) {
    EXPECT_THAT(message("time_s,depth_m,velocity_m_s," + name + "\n0,0.5,8,200\n1,2,14,250\n"),
                HasSubstr("has a column " + name + "; did you mean density_kg_m3?"));
  }
  EXPECT_EQ(message("time_s,entered_s,depth_m,velocity_m_s\n0,0,0.5,8\n1,1,2,14\n"), "") << "others are for other readers";
}

TEST_F(InflowTables, LeaveACaseThatIsCompleteWithoutThem) {
  const Case c = read(surge);
  const std::string text = write_case(c);
  EXPECT_EQ(text.find("inflow_csv"), std::string::npos);
  EXPECT_EQ(parse_case(text, "elsewhere/case.toml"), c);
}

TEST_F(InflowTables, AreRefusedWithFileRowAndRemedy) {
  EXPECT_THAT(message("time_s,depth_m\n0,1\n"), HasSubstr("has no column velocity_m_s, only 'time_s,depth_m'"));
  EXPECT_THAT(message("time_s;depth_m;velocity_m_s\n0;1;8\n"),
              AllOf(HasSubstr("only 'time_s;depth_m;velocity_m_s'"), HasSubstr("commas between")));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s\n"), HasSubstr("has no rows"));
  EXPECT_THAT(message(""), HasSubstr("flow.csv"));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s\n0,1,8\n2,1,8\n1,1,8\n"),
              HasSubstr("row 3: time_s = 1 is not above that of the row before, 2"));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s\n0,1000,8\n"), HasSubstr("check the unit"));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s\n0,1,8000\n"), HasSubstr("check the unit"));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s\n0,0,8\n"), HasSubstr("leave out rows without flow"));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s,density_kg_m3\n0,1,8,100\n"), HasSubstr("0.5 times material.density_kg_m3"));
  EXPECT_THAT(message("time_s,depth_m,velocity_m_s\n0,one,8\n"), HasSubstr("flow.csv"));
  EXPECT_THAT(message(surge, "feed = \"strip\"\n"), HasSubstr("inflow_csv"));
  EXPECT_THAT(message(surge, "[[conveyor.inflow]]\ntime_s = 0\n"), HasSubstr("leave out one of the two"));
}

TEST_F(InflowTables, ThatAreMissingAreNamed) {
  std::ofstream(directory_ / "case.toml") << "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0\nhardening_xi = 5\n[conveyor]\n"
                                             "inflow_csv = \"none.csv\"\n[obstacle]\n[output]\nduration_s = 4\n";
  try {
    (void)read_case(directory_ / "case.toml");
    FAIL() << "no error";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("none.csv"));
    EXPECT_THAT(error.what(), HasSubstr("case.toml:6"));
    EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("has no speed"))) << "one problem, one message";
  }
}

}  // namespace
}  // namespace mpm
