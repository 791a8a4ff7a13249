#include "libmpm/driver/case_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/estimate.hpp"
#include "support/case_texts.hpp"

namespace mpm {
namespace {

using testing::hand_case;
using testing::law_cases;
using testing::lines_of;
using testing::message_of;
using testing::reports;
using testing::sand_case;
using testing::strip_case;
using testing::typical_materials;
using testing::water_case;
using testing::window_case;

TEST(Config, ReadsEveryKey) {
  const Case c = parse_case(window_case, "case.toml");
  EXPECT_EQ(c.title, "all keys of a conveyor");
  EXPECT_EQ(c.material.as<CamClay>().cohesion_beta, 0.15);
  ASSERT_TRUE(c.conveyor && c.obstacle);
  EXPECT_DOUBLE_EQ(c.conveyor->velocity, 3.0 * std::sqrt(9.81 * 1.75));
  EXPECT_EQ(c.conveyor->width, 20.5);
  EXPECT_EQ(c.conveyor->sidewall_contact, Contact::separable);
  EXPECT_EQ(c.conveyor->sidewall_friction, 0.25);
  EXPECT_FALSE(c.conveyor->mirror_y);
  EXPECT_EQ(c.obstacle->height, 10.0);
  EXPECT_EQ(c.numerics.particles_per_cell, 27);
  EXPECT_EQ(c.numerics.transfer, Transfer::flip);
  EXPECT_DOUBLE_EQ(c.numerics.slope, 33.3 * 3.14159265358979324 / 180.0);
  EXPECT_EQ(c.output.series_per_second, 50.0);

  const Case hand = parse_case(hand_case, "case.toml");
  ASSERT_EQ(hand.bodies.size(), 2u);
  EXPECT_EQ(hand.bodies[0].shape, BodySpec::Shape::cylinder);
  EXPECT_EQ(hand.bodies[0].max, Vec3(1.0, 1.0, 4.0));
  EXPECT_EQ(hand.bodies[1].min, Vec3(2.0, 2.0, 0.0));
  ASSERT_EQ(hand.walls.size(), 1u);
  EXPECT_TRUE(hand.walls[0].normal.isApprox(Vec3(0.0, 0.6, 2.0).normalized(), 1e-15));  // rounding of one division
  EXPECT_EQ(hand.walls[0].contact, Contact::separable);
  EXPECT_TRUE(hand.domain.mirror_x);
  EXPECT_EQ(hand.bodies[0].lattice, Lattice::aligned);
  EXPECT_EQ(hand.bodies[1].lattice, Lattice::staggered);
  EXPECT_EQ(hand.numerics.transfer, Transfer::aflip);
  EXPECT_EQ(hand.numerics.relaxation_cells, 1.5);
  EXPECT_EQ(hand.numerics.contact, ContactRule::nodal);
  EXPECT_FALSE(hand.domain.mirror_y);
}

TEST(Config, BodyAtRestBetweenWallsIsAlignedUnlessItsKeySaysOtherwise) {
  const auto lattice = [](const std::string& body, const std::string& last_wall) {
    const auto wall = [](const std::string& point, const std::string& normal) {
      return "[[wall]]\npoint_m = " + point + "\nnormal = " + normal + "\n";
    };
    return parse_case(
               "[material]\nmodel = \"hencky_elastic\"\nyoung_modulus_pa = 1e6\npoisson_ratio = 0.1\n[domain]\nmin_m = [-1, -1, -1]\n"
               "max_m = [4, 3, 3]\nmirror = [\"y\"]\n[numerics]\ncell_size_m = 0.25\n[output]\nduration_s = 1\n[[body]]\n"
               "min_m = [0, 0, 0]\nmax_m = [2, 1, 1]\n" +
                   body + wall("[0, 0, 0]", "[0, 0, 1]") + wall("[0, 0, 0]", "[1, 0, 0]") + wall("[0, 1, 0]", "[0, -1, 0]") +
                   wall("[" + last_wall + ", 0, 0]", "[-1, 0, 0]"),
               "case.toml")
        .bodies.at(0)
        .lattice;
  };
  EXPECT_EQ(lattice("", "2"), Lattice::aligned);
  EXPECT_EQ(lattice("lattice = \"staggered\"\n", "2"), Lattice::staggered);
  EXPECT_EQ(lattice("velocity_m_s = [1, 0, 0]\n", "2"), Lattice::staggered);
  EXPECT_EQ(lattice("shape = \"cylinder\"\n", "2"), Lattice::staggered);
  EXPECT_EQ(lattice("", "3"), Lattice::staggered);  // it can spread
}

TEST(Config, ReadsWhatItWritesOfEveryLaw) {
  const auto materials = typical_materials();
  const auto cases = law_cases();
  for (std::size_t i = 0; i < materials.size(); ++i) {
    EXPECT_EQ(parse_case(cases[i], "law.toml").material, materials[i]) << cases[i];
    for (const KeyInfo& key : case_reference().keys) {
      const auto laws = case_reference().models;
      const auto law = std::ranges::find(laws, materials[i].name(), &ModelInfo::name);
      const bool has = key.table == "material" && std::ranges::find(law->keys, key.name) != law->keys.end();
      if (has && key.left_out.empty()) {
        EXPECT_NE(cases[i].find("\n" + key.name + " = "), std::string::npos) << key.name;
      }
    }
  }
}

TEST(Config, ReadsTheKeysOfSandAndWater) {
  const double degree = 3.14159265358979324 / 180.0;
  const DruckerPrager::Parameters sand = parse_case(sand_case, "case.toml").material.as<DruckerPrager>();
  EXPECT_EQ(sand.cone_matching, ConeMatching::simple_shear);
  EXPECT_DOUBLE_EQ(sand.friction_angle, 20.9 * degree);
  EXPECT_EQ(sand.cohesion, 10.0);
  EXPECT_EQ(sand.dilatancy_angle, 0.0);
  EXPECT_DOUBLE_EQ(sand.limit_friction_angle.value(), 32.76 * degree);
  EXPECT_EQ(sand.reference_inertial_number, 0.279);
  EXPECT_EQ(sand.grain_diameter, 0.53e-3);
  EXPECT_EQ(sand.grain_density, 2450.0);
  EXPECT_NE(write_case(parse_case(sand_case, "case.toml", {"material.friction_angle_deg=30"})).find("friction_angle_deg = 30.0\n"),
            std::string::npos);  // and not 29.999999999999996
  const WeaklyCompressibleFluid::Parameters water = parse_case(water_case, "case.toml").material.as<WeaklyCompressibleFluid>();
  EXPECT_EQ(water.bulk_modulus, 2e5);
  EXPECT_EQ(water.tait_exponent, 3);
  EXPECT_EQ(water.viscosity, 0.5);
  EXPECT_TRUE(water.carries_tension);
}

TEST(Config, FillsInTheDefaultsOfThePaper) {
  const Case c = parse_case(strip_case, "case.toml");
  EXPECT_EQ(c.material.density(), 300.0);
  EXPECT_EQ(c.material.as<CamClay>().young_modulus, 1e6);
  EXPECT_EQ(c.material.as<CamClay>().poisson_ratio, 0.1);
  EXPECT_EQ(c.material.as<CamClay>().preconsolidation_pressure, 1e4);
  EXPECT_EQ(c.conveyor->flow_height, 1.75);
  EXPECT_EQ(c.conveyor->sidewall_contact, Contact::no_slip);
  EXPECT_TRUE(c.conveyor->mirror_y);
  EXPECT_EQ(c.obstacle->friction, 0.15);
  EXPECT_FALSE(c.obstacle->height);
  EXPECT_EQ(c.numerics.cfl, 1.0) << "a flow against an obstacle";
  EXPECT_EQ(parse_case(strip_case, "case.toml", {"numerics.transfer=\"apic\""}).numerics.cfl, 0.4)
      << "a transfer that loses energy in every step";
  EXPECT_EQ(c.numerics.precision, Precision::single_precision) << "likewise";
  EXPECT_EQ(c.numerics.particles_per_cell, 8);
  EXPECT_EQ(c.numerics.transfer, Transfer::aflip);
  EXPECT_EQ(c.numerics.relaxation_cells, 5.0);
  EXPECT_EQ(c.numerics.contact, ContactRule::surface);
}

TEST(Config, PaperWindowFollowsFromXiAndTheObstacle) {
  const double tolerance = 1e-12;  // rounding of a logarithm
  const auto width = [](const std::string& xi) {
    return parse_case(strip_case, "case.toml", {"material.hardening_xi=" + xi, "conveyor.window_size=\"paper\""}).conveyor->width;
  };
  EXPECT_NEAR(width("0.05"), 6 * 1.75, tolerance);
  EXPECT_NEAR(width("0.5"), 9 * 1.75, tolerance);
  EXPECT_NEAR(width("5"), 12 * 1.75, tolerance);
  const Case elastic = parse_case(R"([material]
model = "hencky_elastic"
[conveyor]
velocity_m_s = 1.0
window_size = "paper"
[obstacle]
width_m = 2.0
[output]
duration_s = 1.0
)",
                                  "case.toml");
  EXPECT_EQ(elastic.conveyor->width, 24.0);
  EXPECT_EQ(elastic.conveyor->upstream_length, 8.0);
  EXPECT_EQ(elastic.conveyor->downstream_length, 4.0);
}

TEST(Config, CompactWindowFollowsFromTheObstacleAndTheFlow) {
  const auto window = [](const std::string& froude, const std::string& height, const std::vector<std::string>& more = {}) {
    std::vector<std::string> all{"conveyor.flow_height_m=" + height};
    all.insert(all.end(), more.begin(), more.end());
    const Case c = parse_case(
        "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0.0\nhardening_xi = 0.5\n[conveyor]\nfroude_number = " + froude +
            "\n[obstacle]\nwidth_m = 1.0\ndepth_m = 1.5\n[output]\nduration_s = 6.0\n",
        "case.toml", all);
    return std::array{c.conveyor->width, c.conveyor->upstream_length, c.conveyor->downstream_length};
  };
  using Lengths = std::array<double, 3>;
  EXPECT_EQ(window("3", "1"), (Lengths{8.0, 4.0, 2.5}));
  EXPECT_EQ(window("3", "4"), (Lengths{12.0, 8.0, 3.5})) << "deep flow on a thin mast: sqrt(w H)";
  EXPECT_EQ(window("0.9", "1"), (Lengths{8.0, 4.0, 3.5})) << "subcritical";
  EXPECT_EQ(window("3", "1", {"material.critical_state_slope=1.2", "material.cohesion_beta=0.45"}), (Lengths{8.0, 10.0, 5.5}))
      << "M' = 2.3";
  EXPECT_EQ(window("3", "1", {"conveyor.width_m=9"}), (Lengths{9.0, 4.0, 2.5}));
  EXPECT_EQ(window("3", "1", {"conveyor.upstream_length_m=5"}), (Lengths{8.0, 5.0, 2.5}));
}

TEST(Config, WrittenCaseReadsBackToTheSameBits) {
  for (const std::string& text : {window_case, strip_case, hand_case, sand_case, water_case}) {
    const Case c = parse_case(text, "case.toml");
    const std::string written = write_case(c);
    EXPECT_EQ(parse_case(written, "written.toml"), c) << written;
    EXPECT_EQ(write_case(parse_case(written, "written.toml")), written);
  }
}

TEST(Config, AnySlopeAndNormalKeepTheirBitsWhenWritten) {
  for (int i = 0; i < 2000; ++i) {
    const double x = -89.9 + 0.0899123456789 * i;  // hits many roundings of degrees and radians
    const Case c =
        parse_case(hand_case, "case.toml",
                   {"domain.mirror=[]", fmt::format("numerics.slope_deg={}", x), fmt::format("wall[0].normal=[1.0, {}, 0.3]", x)});
    EXPECT_EQ(parse_case(write_case(c), "written.toml"), c) << x;
  }
}

TEST(Config, TitleWithAnyCharactersSurvives) {
  Case c = parse_case(strip_case, "case.toml");
  c.title = "quote \" backslash \\ newline \n tab \t bell \a delete \x7f umlaut \u00fc";
  EXPECT_EQ(parse_case(write_case(c), "written.toml").title, c.title);
}

TEST(Config, AllFaultsAreReportedTogetherInTheOrderOfTheFile) {
  const std::string text = R"(titel = "x"
[material]
model = "cohesive_camclay"
density_kg_m3 = "heavy"
poisson_ratio = 0.5
hardening_xi = nan
critical_state_slope = 0.4
[conveyer]
froude_number = 3
velocity_m_s = 3.0
[obstacle]
friction = -0.1
[numerics]
particles_per_cell = 9
)";
  const auto lines = lines_of(message_of(text, {"numerics.cfl=2"}));
  const std::vector<std::string> expected{
      "case.toml:1:1: unknown key titel; did you mean title?",
      "case.toml:3:9: [material] model = \"cohesive_camclay\" is not known (did you mean \"cohesive_cam_clay\"?)",
      "case.toml:4:17: [material] density_kg_m3 = \"heavy\" is a string; give a number in [1, 100000] kg/m^3",
      "case.toml:5:17: [material] poisson_ratio = 0.5 is out of range; give a number in [0, 0.5)",
      "case.toml:6:16: [material] hardening_xi = nan is not a finite number",
      "case.toml:8:2: unknown table [conveyer]; did you mean [conveyor]?",
      "case.toml:10:16: [conveyor] velocity_m_s is given beside froude_number",
      "case.toml:12:12: [obstacle] friction = -0.1 is out of range",
      "case.toml:14:22: [numerics] particles_per_cell = 9 is out of range; give one of 1, 8, 27, 64",
      "--set numerics.cfl=2: [numerics] cfl = 2 is out of range; give a number in [1e-09, 1]",
  };
  const std::string missing_output = "case.toml:1:1: [output] duration_s is missing; give a number in [1e-09, 1e+06] s";
  ASSERT_EQ(lines.size(), expected.size() + 1);
  EXPECT_TRUE(reports(fmt::format("{}", fmt::join(lines, "\n")), missing_output, {}));
  std::size_t next = 0;
  for (const std::string& line : lines) {
    if (line.starts_with(missing_output)) continue;
    EXPECT_TRUE(line.starts_with(expected[next])) << line << "\ninstead of\n" << expected[next];
    ++next;
  }
}

TEST(Config, OddNamesStayOnOneLine) {
  const std::string message = message_of("\"two\\nlines\" = 1\n" + strip_case);
  EXPECT_TRUE(reports(message, "case.toml:1:1: ", {"unknown key two lines"}));
  EXPECT_EQ(lines_of(message).size(), 1u) << message;
}

TEST(Config, SyntaxErrorsAndDuplicatesAreReportedWithTheirPlace) {
  EXPECT_TRUE(reports(message_of("title = \"a\"\n[material]\nmodel = \n"), "case.toml:3:", {"TOML"}));
  EXPECT_TRUE(reports(message_of("[material]\n[material]\n"), "case.toml:2:", {"TOML"}));
  EXPECT_TRUE(reports(message_of("title = \"a\"\ntitle = \"b\"\n"), "case.toml:2:", {"TOML"}));
  EXPECT_TRUE(reports(message_of("title = \"\xff\xfe\"\n"), "case.toml:1:", {"TOML"}));
}

TEST(Config, MissingKeysAreReportedAtTheirTable) {
  EXPECT_TRUE(reports(message_of("[material]\n[conveyor]\nvelocity_m_s = 1\n[obstacle]\n[output]\nduration_s = 1\n"),
                      "case.toml:1:1: ", {"[material] critical_state_slope is missing (required with model = \"cohesive_cam_clay\")"}));
  EXPECT_TRUE(reports(message_of("title = \"x\"\n[output]\n"), "case.toml:2:1: ", {"[output] duration_s is missing"}));
  EXPECT_TRUE(reports(message_of("\n"), "case.toml:1:1: ", {"the scene is empty"}));
  EXPECT_TRUE(reports(message_of("[conveyor]\n"), "case.toml:1:1: ", {"no speed", "froude_number or velocity_m_s"}));
  EXPECT_TRUE(reports(message_of("[conveyor]\n"), "case.toml:1:1: ", {"width_m is missing", "obstacle"}));
  EXPECT_TRUE(reports(message_of("[[body]]\n"), "case.toml:1:1: ", {"[body[0]] min_m is missing"}));
  EXPECT_TRUE(reports(message_of("[[body]]\n"), "case.toml:1:1: ", {"[domain] min_m is missing (required with no [conveyor])"}));
}

TEST(Config, OverridesReplaceValues) {
  const auto overridden = [](const std::string& text, const std::vector<std::string>& overrides) {
    return parse_case(text, "case.toml", overrides);
  };
  EXPECT_EQ(overridden(window_case, {"numerics.cfl=0.25", "title = two words"}).numerics.cfl, 0.25);
  EXPECT_EQ(overridden(window_case, {"title = two words"}).title, "two words");
  EXPECT_EQ(overridden(window_case, {"title=\"quoted = 1\""}).title, "quoted = 1");
  EXPECT_EQ(overridden(window_case, {"conveyor.feed=window"}).conveyor->feed, ConveyorSpec::Feed::window);
  EXPECT_EQ(overridden(window_case, {"numerics.cfl=0.25", "numerics.cfl=0.125"}).numerics.cfl, 0.125);
  EXPECT_EQ(overridden(hand_case, {"body[1].velocity_m_s=[1,0,0]"}).bodies[1].velocity, Vec3(1, 0, 0));
  EXPECT_EQ(overridden(hand_case, {"numerics.cell_size_m=0.5"}).numerics.cell_size, 0.5);  // a table that the file does not have
}

TEST(Config, OverrideOfOneSpeedReplacesTheOther) {
  EXPECT_EQ(parse_case(window_case, "case.toml", {"conveyor.velocity_m_s=2"}).conveyor->velocity, 2.0);
  EXPECT_DOUBLE_EQ(parse_case(strip_case, "case.toml", {"conveyor.froude_number=2"}).conveyor->velocity, 2.0 * std::sqrt(9.81 * 1.75));
  EXPECT_NE(message_of(strip_case, {"conveyor.froude_number=2", "conveyor.velocity_m_s=2", "conveyor.froude_number=x"}), "");
}

TEST(Config, TwoKeysOfTheSameQuantityAreRefusedInAFileAndInOverrides) {
  for (const KeyInfo& key : case_reference().keys) {
    for (const std::string& other : key.excludes) {
      SCOPED_TRACE(key.table + "." + key.name + " and " + other);
      const std::vector<std::string> both{key.table + "." + other + "=1", key.table + "." + key.name + "=1"};
      EXPECT_TRUE(reports(message_of(strip_case, both), "--set " + both[1], {key.name + " is given beside " + other, "leave one out"}));
      const std::vector<std::string> turned{both[1], both[0]};
      EXPECT_TRUE(reports(message_of(strip_case, turned), "--set " + both[1], {key.name + " is given beside " + other}));
      for (const std::string& alone : both) {  // a text has no value that is right for every key
        const std::string message = message_of(strip_case, {alone});
        if (key.type == ParameterType::text) {
          EXPECT_EQ(message.find("is given beside"), std::string::npos) << message;
        } else {
          EXPECT_EQ(message, "");
        }
      }
    }
  }
  EXPECT_EQ(case_schema().rivals("conveyor.velocity_m_s"), std::vector<std::string>{"conveyor.froude_number"});
  EXPECT_EQ(case_schema().rivals("obstacle.friction"), std::vector<std::string>{"obstacle.friction_ratio"});
}

TEST(Config, ANumberThatNoKeyCanHoldIsNotCalledAString) {
  for (const char* word : {"NaN", "nan", "-nan", "Inf", "inf", "infinity"})
    EXPECT_TRUE(reports(message_of(strip_case, {fmt::format("numerics.cfl={}", word)}), "--set", {"is not a finite number"})) << word;
  for (const char* word : {"1e400", "-1e999", "+1E+4000"})
    EXPECT_TRUE(reports(message_of(strip_case, {fmt::format("numerics.cfl={}", word)}), "--set", {"is too large for a number"})) << word;
  EXPECT_TRUE(reports(message_of(strip_case, {"numerics.particles_per_cell=NaN"}), "--set", {"is not a finite number"}));
  EXPECT_TRUE(reports(message_of(strip_case, {"numerics.cfl=fast"}), "--set", {"is a string"}));
  EXPECT_TRUE(reports(message_of(strip_case, {"numerics.cfl=\"0.3\""}), "--set", {"is a string"}));
}

TEST(Config, HashChangesWithPhysicsOnly) {
  const auto hash = [](const std::string& text, const std::vector<std::string>& overrides) {
    return case_hash(parse_case(text, "case.toml", overrides));
  };
  const std::uint64_t window = hash(window_case, {});
  EXPECT_EQ(hash(window_case, {"title=other", "output.duration_s=60", "output.stop_when_steady=0.05", "output.checkpoint_minutes=1"}),
            window);
  EXPECT_EQ(hash(write_case(parse_case(window_case, "case.toml")), {}), window);
  EXPECT_EQ(hash(window_case, {"obstacle.base_m=0"}), window) << "it stands on the ground";
  EXPECT_NE(hash(window_case, {"obstacle.base_m=1"}), window);
  EXPECT_EQ(hash(window_case, {"measurement.steady_by=runup"}), window) << "only the times of the means";
  EXPECT_NE(hash(window_case, {"material.critical_state_slope=0.4000000001"}), window);
  EXPECT_NE(hash(window_case, {"numerics.cell_size_m=0.2"}), window);
  EXPECT_NE(hash(window_case, {"output.series_per_second=49"}), window);
  EXPECT_NE(hash(strip_case, {"output.duration_s=60"}), hash(strip_case, {}));  // the strip is as long as the run needs
  const std::string text = case_hash_text(parse_case(window_case, "case.toml"));
  EXPECT_EQ(std::stoull(text, nullptr, 16), window);
  EXPECT_EQ(text.size(), 16u);
}

TEST(Config, UnreadableFileIsAnInputError) {
  EXPECT_THROW((void)read_case("does/not/exist.toml"), IoError);
  EXPECT_THROW((void)read_case(std::filesystem::temp_directory_path()), IoError);
}

TEST(Config, ExamplesAreValidAndAffordable) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(MPM_SOURCE_DIR) / "examples")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().filename());
    ++count;
    const Case c = read_case(entry.path());
    EXPECT_FALSE(c.title.empty());
    EXPECT_LT(estimate(c).memory_bytes, 1e9);                                                  // a laptop of any age
    const double splash = c.conveyor ? 2.0 * c.conveyor->velocity / c.numerics.gravity : 0.0;  // time of flight of the first jet, s
    EXPECT_GT(c.output.duration, splash);
  }
  EXPECT_GE(count, 6);
}

}  // namespace
}  // namespace mpm
