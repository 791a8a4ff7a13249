#include "libmpm/driver/point_path.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "support/case_texts.hpp"

namespace mpm {
namespace {

using testing::lines_of;
using testing::reports;

const std::string path_head = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[path]
)";

std::string path_message(const std::string& path_keys) {
  try {
    (void)parse_path(path_head + path_keys, "path.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(PathFile, ReadsEveryKindOfSegment) {
  const PathSpec path = parse_path(path_head + R"(steps_per_segment = 80
segments = [ { d_eps_v = -0.012, d_eps_q = 0.0 }, { d_eps_q = 0.05 },
  { velocity_gradient = [[0, 1, 2], [3, 4, 5], [6, 7, 8.5]], time_s = 2 }, { radial_stress_pa = 2.0e4, d_eps_axial = -0.2 } ]
)",
                                   "path.toml");
  EXPECT_EQ(path.material.as<CamClay>().cohesion_beta, 0.3);
  EXPECT_EQ(path.steps_per_segment, 80);
  ASSERT_EQ(path.segments.size(), 4u);
  EXPECT_EQ(std::get<StrainSegment>(path.segments[0]).d_eps_v, -0.012);
  EXPECT_EQ(std::get<StrainSegment>(path.segments[1]).d_eps_q, 0.05);
  EXPECT_EQ(std::get<StrainSegment>(path.segments[1]).d_eps_v, 0.0);
  const auto& gradient = std::get<VelocityGradientSegment>(path.segments[2]);
  EXPECT_EQ(gradient.velocity_gradient(0, 2), 2.0);  // by rows
  EXPECT_EQ(gradient.velocity_gradient(2, 2), 8.5);
  EXPECT_EQ(gradient.time, 2.0);
  EXPECT_EQ(std::get<TriaxialSegment>(path.segments[3]).radial_stress, 2e4);
  EXPECT_EQ(std::get<TriaxialSegment>(path.segments[3]).d_eps_axial, -0.2);
}

TEST(PathFile, StrainBeyondWhatALawIsMadeForIsRefused) {
  for (const char* key : {"d_eps_v", "d_eps_q"}) {
    EXPECT_TRUE(reports(path_message(fmt::format("segments = [ {{ {} = 9.9 }} ]\n", key)),
                        "path.toml:6:", {"out of range; give a number in [-2, 2]"}));
    EXPECT_EQ(path_message(fmt::format("segments = [ {{ {} = -2.0 }} ]\n", key)), "");
  }
  EXPECT_TRUE(reports(path_message("segments = [ { d_eps_axial = -9.9, radial_stress_pa = 1e4 } ]\n"), "path.toml:6:", {"out of range"}));
}

TEST(PathFile, SetReplacesKeysOfASegment) {
  const PathSpec path = parse_path(path_head + "segments = [ { d_eps_v = -0.012 } ]\n", "path.toml", {"path.segments[0].d_eps_v=0.5"});
  EXPECT_EQ(std::get<StrainSegment>(path.segments.at(0)).d_eps_v, 0.5);
}

TEST(PathFile, FaultsOfEveryKeyAreReportedWithTheirPlace) {
  for (const KeyInfo& key : case_reference().keys) {
    if (!key.table.starts_with("path")) continue;
    SCOPED_TRACE(key.name);
    const bool segment = key.table == "path.segments";
    // one line: segments = [ { KEY = VALUE } ]; an innocent segment beside the keys of [path]
    const auto line = [&](const std::string& name, const std::string& value) {
      return segment ? "segments = [ { " + name + " = " + value + " } ]\n" : name + " = " + value + "\nsegments = [ { d_eps_v = 0.1 } ]\n";
    };
    const std::size_t start = segment ? 16 : 1;
    const std::string at_key = fmt::format("path.toml:6:{}: ", start);
    const std::string at_value = fmt::format("path.toml:6:{}: ", start + key.name.size() + 3);
    EXPECT_TRUE(reports(path_message(line(key.name, "true")), at_value, {key.name + " = true is a boolean; give "}));
    ASSERT_TRUE(key.range);
    if (key.type == KeyType::matrix) {
      EXPECT_TRUE(reports(path_message(line(key.name, "[[0, 0, 0], [0, 0, 1e9], [0, 0, 0]]")), at_value, {"out of range"}));
      EXPECT_TRUE(reports(path_message(line(key.name, "[[0, 0, 0], [0, nan, 0], [0, 0, 0]]")), at_value, {"finite"}));
      EXPECT_TRUE(reports(path_message(line(key.name, "[[0, 0, 0], [0, 0], [0, 0, 0]]")), at_value, {"has 2 entries"}));
      EXPECT_TRUE(reports(path_message(line(key.name, "[[0, 0, 0]]")), at_value, {"three rows of three numbers"}));
    } else {
      const std::string beyond = key.type == KeyType::integer ? "1000000000" : "1e300";
      EXPECT_TRUE(reports(path_message(line(key.name, beyond)), at_value, {"out of range"}));
    }
    std::string wrong = key.name;
    wrong.erase(wrong.size() / 2, 1);
    EXPECT_TRUE(reports(path_message(line(wrong, "1")), at_key, {"unknown key " + wrong + "; did you mean " + key.name + "?"}));
  }
}

TEST(PathFile, MixedAndIncompleteSegmentsAreRefused) {
  for (const char* segment :
       {"{ }", "{ d_eps_v = 0.1, time_s = 1.0 }", "{ velocity_gradient = [[0, 0, 0], [0, 0, 0], [0, 0, 0]] }", "{ time_s = 1 }",
        "{ radial_stress_pa = 1e4 }", "{ d_eps_axial = 0.1 }", "{ d_eps_q = 0.1, d_eps_axial = 0.1, radial_stress_pa = 1 }"}) {
    const std::string message = path_message("segments = [ { d_eps_v = 0.1 }, " + std::string(segment) + " ]\n");
    EXPECT_TRUE(reports(message, "path.toml:6:33: ", {"[path.segments[1]] is not one of", "give exactly one"})) << segment;
    EXPECT_EQ(lines_of(message).size(), 1u) << message;
  }
  EXPECT_TRUE(reports(path_message(""), "path.toml:5:1: ", {"segments is missing or empty"}));
  EXPECT_TRUE(reports(path_message("segments = []\n"), "path.toml:", {"segments is missing or empty"}));
  EXPECT_TRUE(reports(path_message("segments = 3\n"), "path.toml:6:1: ", {"is an integer; write"}));
  EXPECT_TRUE(reports(path_message("segments = [3]\n"), "path.toml:6:13: ", {"is an integer; give a table"}));
  EXPECT_TRUE(reports(path_message("segments = [ { d_eps_v = 0.1 } ]\n[conveyor]\n"), "path.toml:7:2: ", {"unknown table [conveyor]"}));
}

}  // namespace
}  // namespace mpm
