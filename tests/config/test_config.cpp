#include "libmpm/driver/case_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_schema.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/driver/schema.hpp"
#include "support/typical_materials.hpp"

namespace mpm {
namespace {

/// Three valid cases that hold every key of a case between them, and no key twice in a case except in [material].
const std::string window_case = R"(title = "all keys of a conveyor"
format_version = 1
[material]
model = "cohesive_cam_clay"
density_kg_m3 = 300.0
young_modulus_pa = 1.0e6
poisson_ratio = 0.1
critical_state_slope = 0.4
cohesion_beta = 0.15
hardening_xi = 5.0
preconsolidation_pressure_pa = 1.0e4
[conveyor]
froude_number = 3.0
flow_height_m = 1.75
width_m = 20.5
feed = "window"
upstream_length_m = 8.0
downstream_length_m = 4.0
sidewall_contact = "coulomb"
sidewall_friction = 0.25
mirror_y = false
[obstacle]
shape = "box"
width_m = 1.75
depth_m = 1.5
height_m = 10.0
friction = 0.1
[numerics]
cell_size_m = 0.25
particles_per_cell = 27
transfer = "flip"
flip_ratio = 0.9
cfl = 0.3
gravity_m_s2 = 9.81
slope_deg = 33.3
grid_offset_cells = [0.25, 0.5, -0.75]
[measurement]
bin_height_m = 0.125
filter_length_m = 1.625
box_upstream_m = 0.625
box_inside_m = 0.125
[output]
duration_s = 6.0
series_per_second = 50
frames_per_second = 5
checkpoint_minutes = 2.5
stop_when_steady = 0.02
)";

const std::string strip_case = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[conveyor]
velocity_m_s = 12.3
feed = "strip"
[obstacle]
[output]
duration_s = 6.0
)";

const std::string sheared_case = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[conveyor]
froude_number = 1.0
sidewall_contact = "slip"
lattice = "aligned"
mirror_y = false
inflow_slip_ratio = 0.5
inflow_shear_exponent = 2.0
[obstacle]
rotation_deg = 20.0
friction_ratio = 0.5
[measurement]
force_window_s = 0.2
[output]
duration_s = 6.0
)";

const std::string surge_case = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[conveyor]
velocity_m_s = 12.3
[[conveyor.inflow]]
time_s = 0.5
velocity_m_s = 10.0
flow_height_m = 1.5
density_ratio = 1.1
[obstacle]
shape = "wedge"
[output]
duration_s = 6.0
)";

const std::string hand_case = R"([material]
model = "hencky_elastic"
[[body]]
shape = "cylinder"
min_m = [-1.0, -1.0, 0.0]
max_m = [1.0, 1.0, 4]
velocity_m_s = [0.0, 0.5, 0.0]
lattice = "aligned"
[[body]]
min_m = [2.0, 2.0, 0.0]
max_m = [3.0, 3.0, 1.0]
[[wall]]
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.6, 2.0]
contact = "separable"
friction = 0.4
velocity_m_s = [0.0, 0.0, 0.1]
[domain]
min_m = [-5.0, -5.0, -1.0]
max_m = [5.0, 5.0, 6.0]
mirror = ["x"]
[numerics]
transfer = "aflip"
relaxation_cells = 1.5
contact = "nodal"
[output]
duration_s = 1.0
)";

const std::string small_scene = R"([[body]]
min_m = [0, 0, 0]
max_m = [1, 1, 1]
[domain]
min_m = [0, 0, 0]
max_m = [1, 1, 1]
[output]
duration_s = 1
)";

const std::string sand_case = R"([material]
model = "drucker_prager"
cone_matching = "simple_shear"
friction_angle_deg = 20.9
cohesion_pa = 10.0
dilatancy_angle_deg = 0.0
limit_friction_angle_deg = 32.76
reference_inertial_number = 0.279
grain_diameter_m = 0.53e-3
grain_density_kg_m3 = 2450.0
)" + small_scene;

const std::string water_case = R"([material]
model = "weakly_compressible_fluid"
bulk_modulus_pa = 2e5
tait_exponent = 3
viscosity_pa_s = 0.5
carries_tension = true
)" + small_scene;

const std::string single_bracket_case = R"([material]
model = "hencky_elastic"
[body]
min_m = [0, 0, 0]
max_m = [1, 1, 1]
[domain]
min_m = [0, 0, 0]
max_m = [1, 1, 1]
[output]
duration_s = 1
)";

std::string message_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    (void)parse_case(text, "case.toml", overrides);
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "";
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// A line of a case that sets a key, and its position (counted from 1).
struct Setting {
  std::string text;
  const KeyInfo* key;
  int line;
};

/// The settings of a case, by table; of repeated tables the first entry.
std::vector<Setting> settings_of(const std::string& text) {
  std::vector<Setting> settings;
  std::string table;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    if (line.starts_with("[")) {
      table = line.substr(line.find_first_not_of('['));
      table.resize(table.find(']'));
      continue;
    }
    const std::string name = line.substr(0, line.find(' '));
    for (const KeyInfo& key : schema_keys()) {
      const bool seen = std::any_of(settings.begin(), settings.end(), [&](const Setting& s) { return s.key == &key; });
      if (key.table == table && key.name == name && !seen) settings.push_back({text, &key, static_cast<int>(i) + 1});
    }
  }
  return settings;
}

/// A case for every law, with every parameter that the law has.
std::vector<std::string> law_cases() {
  std::vector<std::string> cases;
  for (const MaterialParameters& material : testing::typical_materials()) {
    Case c = parse_case("[material]\nmodel = \"hencky_elastic\"\n" + small_scene, "small.toml");
    c.material = material;
    cases.push_back(write_case(c));
  }
  return cases;
}

/// One setting for every key that may be in a case.
std::vector<Setting> every_case_key() {
  std::vector<Setting> all;
  std::vector<std::string> cases{window_case, strip_case, sheared_case, surge_case, hand_case};
  for (const std::string& text : law_cases()) cases.push_back(text);
  for (const std::string& text : cases) {
    for (const Setting& setting : settings_of(text)) {
      if (std::none_of(all.begin(), all.end(), [&](const Setting& s) { return s.key == setting.key; })) all.push_back(setting);
    }
  }
  return all;
}

std::string with_line(const Setting& setting, const std::string& line) {
  std::string out;
  int number = 0;
  for (const std::string& old : lines_of(setting.text)) out += (++number == setting.line ? line : old) + "\n";
  return out;
}

std::string value_place(const Setting& setting) { return fmt::format("case.toml:{}:{}: ", setting.line, setting.key->name.size() + 4); }
std::string key_place(const Setting& setting) { return fmt::format("case.toml:{}:1: ", setting.line); }

/// One line of the message begins with `place` and holds all of `words`.
::testing::AssertionResult reports(const std::string& message, const std::string& place, const std::vector<std::string>& words) {
  for (const std::string& line : lines_of(message)) {
    const bool all = std::all_of(words.begin(), words.end(), [&](const std::string& w) { return line.find(w) != std::string::npos; });
    if (line.starts_with(place) && all) return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "no line at " << place << "with these words in:\n" << message;
}

class EveryKey : public ::testing::TestWithParam<Setting> {};

TEST_P(EveryKey, OfWrongTypeIsReportedWithPlaceAndRemedy) {
  const Setting& s = GetParam();
  const std::string wrong = s.key->type == KeyType::boolean ? "1" : "true";
  const std::string message = message_of(with_line(s, s.key->name + " = " + wrong));
  EXPECT_TRUE(reports(message, value_place(s), {s.key->name + " = " + wrong, "give "}));
  EXPECT_TRUE(reports(message_of(with_line(s, s.key->name + " = 2020-02-02")), value_place(s), {"date"}));
}

TEST_P(EveryKey, OutOfRangeIsReportedWithPlaceValueAndRange) {
  const Setting& s = GetParam();
  const auto refused = [&](const std::string& value, const std::vector<std::string>& words) {
    const std::string message = message_of(with_line(s, s.key->name + " = " + value));
    EXPECT_TRUE(reports(message, value_place(s), words)) << value;
  };
  switch (s.key->type) {
    case KeyType::number:
    case KeyType::vector:
    case KeyType::matrix: {
      ASSERT_TRUE(s.key->range);
      const auto literal = [&](const std::string& x) { return s.key->type == KeyType::vector ? "[0.5, " + x + ", 0]" : x; };
      const Range& range = *s.key->range;
      const double low = range.low_open ? range.low : range.low - 1e-3 * std::max(1.0, std::abs(range.low));
      const double high = range.high_open ? range.high : range.high + 1e-3 * std::max(1.0, std::abs(range.high));
      refused(literal(fmt::format("{:.17e}", low)), {"out of range", fmt::format("{:g}", range.low)});
      refused(literal(fmt::format("{:.17e}", high)), {"out of range", fmt::format("{:g}", range.high)});
      for (const char* odd : {"nan", "inf", "-inf", "+nan"}) refused(literal(odd), {"finite"});
      break;
    }
    case KeyType::integer:
      if (s.key->range) {
        refused(fmt::format("{}", s.key->range->low - 1), {"out of range", fmt::format("{:g}", s.key->range->low)});
      } else {
        refused("9", {"out of range", s.key->choices.front()});
      }
      break;
    case KeyType::choice: refused("\"zzzzzzzz\"", {"not known", s.key->choices.front()}); break;
    case KeyType::axes:
      refused("[\"z\"]", {"holds \"z\""});
      refused("[\"x\", \"x\"]", {"twice"});
      refused("[1]", {"holds 1"});
      break;
    case KeyType::text:
    case KeyType::boolean: break;  // no range
  }
}

TEST_P(EveryKey, MisspeltIsReportedWithTheRightSuggestion) {
  const Setting& s = GetParam();
  const std::string line = lines_of(s.text)[static_cast<std::size_t>(s.line) - 1];
  const std::string& name = s.key->name;
  std::string doubled = name, dropped = name, swapped = name;
  doubled.insert(2, 1, name[2]);
  dropped.erase(name.size() / 2, 1);
  std::swap(swapped[1], swapped[2]);
  for (const std::string& wrong : {doubled, dropped, swapped}) {
    if (wrong == name) continue;
    const std::string message = message_of(with_line(s, wrong + line.substr(name.size())));
    EXPECT_TRUE(reports(message, key_place(s), {"unknown key " + wrong + "; did you mean " + name + "?"}));
    EXPECT_EQ(lines_of(message).size(), 1u) << message;  // and not as missing, too
  }
}

TEST_P(EveryKey, InAnotherTableIsSentToItsOwn) {
  const Setting& s = GetParam();
  const std::string foreign = s.key->table == "output" ? "numerics" : "output";
  const std::string message = message_of(strip_case + (foreign == "output" ? "" : "[numerics]\n") + s.key->name + " = 1\n");
  EXPECT_TRUE(reports(message, "case.toml:", {"unknown key " + s.key->name + "; it belongs in "}));
}

INSTANTIATE_TEST_SUITE_P(Config, EveryKey, ::testing::ValuesIn(every_case_key()), [](const auto& param) {
  const KeyInfo& key = *param.param.key;
  std::string name = (key.table.empty() ? "top" : key.table) + "_" + key.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(ConfigTest, CoversEveryKeyOfTheSchema) {
  const auto covered = every_case_key();
  for (const KeyInfo& key : schema_keys()) {
    if (key.table.starts_with("path")) continue;
    if (key.name == "inflow_csv") continue;  // it needs a file beside the case: tests/driver/test_inflow_csv.cpp
    EXPECT_TRUE(std::any_of(covered.begin(), covered.end(), [&](const Setting& s) { return s.key == &key; }))
        << key.table << "." << key.name;
  }
}

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
  EXPECT_EQ(hand.bodies[0].lattice, BodySpec::Lattice::aligned);
  EXPECT_EQ(hand.bodies[1].lattice, BodySpec::Lattice::staggered);
  EXPECT_EQ(hand.numerics.transfer, Transfer::aflip);
  EXPECT_EQ(hand.numerics.relaxation_cells, 1.5);
  EXPECT_EQ(hand.numerics.contact, ContactRule::nodal);
  EXPECT_FALSE(hand.domain.mirror_y);
}

TEST(Config, ReadsWhatItWritesOfEveryLaw) {
  const auto materials = testing::typical_materials();
  const auto cases = law_cases();
  for (std::size_t i = 0; i < materials.size(); ++i) {
    EXPECT_EQ(parse_case(cases[i], "law.toml").material, materials[i]) << cases[i];
    for (const KeyInfo& key : schema_keys()) {
      const auto laws = schema_models();
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
  EXPECT_EQ(c.numerics.cfl, 0.4);
  EXPECT_EQ(c.numerics.particles_per_cell, 8);
  EXPECT_EQ(c.numerics.transfer, Transfer::aflip);
  EXPECT_EQ(c.numerics.relaxation_cells, 5.0);
  EXPECT_EQ(c.numerics.contact, ContactRule::surface);
}

TEST(Config, WidthFollowsFromXiAndTheObstacle) {
  const double tolerance = 1e-12;  // rounding of a logarithm
  const auto width = [](const std::string& xi) {
    return parse_case(strip_case, "case.toml", {"material.hardening_xi=" + xi}).conveyor->width;
  };
  EXPECT_NEAR(width("0.05"), 6 * 1.75, tolerance);
  EXPECT_NEAR(width("0.5"), 9 * 1.75, tolerance);
  EXPECT_NEAR(width("5"), 12 * 1.75, tolerance);
  const Case elastic = parse_case(R"([material]
model = "hencky_elastic"
[conveyor]
velocity_m_s = 1.0
[obstacle]
width_m = 2.0
[output]
duration_s = 1.0
)",
                                  "case.toml");
  EXPECT_EQ(elastic.conveyor->width, 24.0);
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
        parse_case(hand_case, "case.toml", {fmt::format("numerics.slope_deg={}", x), fmt::format("wall[0].normal=[1.0, {}, 0.3]", x)});
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

struct BadCase {
  std::string name;
  std::string base;
  std::vector<std::string> overrides;
  std::vector<std::string> words;
};

std::ostream& operator<<(std::ostream& out, const BadCase& bad) { return out << bad.name; }

class Inconsistent : public ::testing::TestWithParam<BadCase> {};

TEST_P(Inconsistent, CaseIsRefusedWithOneLine) {
  const BadCase& bad = GetParam();
  const std::string message = message_of(bad.base, bad.overrides);
  EXPECT_TRUE(reports(message, "", bad.words));
  EXPECT_EQ(lines_of(message).size(), 1u) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Config, Inconsistent,
    ::testing::Values(
        BadCase{"law_without_the_key",
                hand_case,
                {"material.hardening_xi=5"},
                {"hardening_xi is used with model = \"cohesive_cam_clay\" only"}},
        BadCase{"dilatancy_above_friction",
                "[material]\nmodel = \"drucker_prager\"\nfriction_angle_deg = 30\ndilatancy_angle_deg = 31\n" + small_scene,
                {},
                {"[material] dilatancy_angle_deg is above friction_angle_deg", "give at most that"}},
        BadCase{"dilatancy_with_rate_dependence",
                sand_case,
                {"material.dilatancy_angle_deg=1"},
                {"dilatancy_angle_deg is given beside limit_friction_angle_deg"}},
        BadCase{"limit_below_friction", sand_case, {"material.limit_friction_angle_deg=20"}, {"is below friction_angle_deg"}},
        BadCase{"three_of_four_rate_keys",
                "[material]\nmodel = \"drucker_prager\"\nfriction_angle_deg = 30\nlimit_friction_angle_deg = 33\n"
                "reference_inertial_number = 0.3\ngrain_diameter_m = 0.001\n" +
                    small_scene,
                {},
                {"grain_density_kg_m3 is missing beside limit_friction_angle_deg"}},
        BadCase{"flip_ratio_with_apic", window_case, {"numerics.transfer=apic"}, {"flip_ratio is used with transfer = \"flip\" only"}},
        BadCase{"friction_on_a_no_slip_wall", hand_case, {"wall[0].contact=no_slip"}, {"[wall[0]] friction is used with contact"}},
        BadCase{"sidewall_friction_without_coulomb", window_case, {"conveyor.sidewall_contact=slip"}, {"sidewall_friction is used with"}},
        BadCase{"coulomb_without_friction", strip_case, {"conveyor.sidewall_contact=coulomb"}, {"sidewall_friction is missing"}},
        BadCase{"strip_with_a_window_length",
                strip_case,
                {"conveyor.upstream_length_m=8"},
                {"upstream_length_m is used with feed = \"window\" only"}},
        BadCase{"offset_moves_the_mirror",
                strip_case,
                {"numerics.grid_offset_cells=[0, 0.5, 0]"},
                {"[numerics] grid_offset_cells shifts the mirror plane y = 0 off the grid by 0.5 cells in y", "give 0 there"}},
        BadCase{"filter_of_half_bins",
                strip_case,
                {"measurement.filter_length_m=1.7", "measurement.bin_height_m=0.125"},
                {"[measurement] filter_length_m = 1.7 is 13.6 bins of 0.125 m; give an odd number of bins", "such as 1.625 m"}},
        BadCase{"filter_of_even_bins", strip_case, {"measurement.filter_length_m=1.5"}, {"is 12 bins of 0.125 m"}},
        BadCase{"filter_of_one_bin", strip_case, {"measurement.filter_length_m=0.125"}, {"is 1 bin of", "at least 3", "such as 0.375 m"}},
        BadCase{"measurement_without_an_impact",
                hand_case,
                {"measurement.box_upstream_m=0.5"},
                {"[measurement] box_upstream_m is used with [conveyor] and [obstacle] only"}},
        BadCase{"mirror_with_a_conveyor", strip_case, {"domain.mirror=[\"y\"]"}, {"mirror is used with no [conveyor] only"}},
        BadCase{"body_with_a_conveyor",
                strip_case + "[[body]]\nmin_m = [-4, 0, 0]\nmax_m = [-3, 1, 1]\n",
                {},
                {"[body[0]] is given beside [conveyor]"}},
        BadCase{"wall_with_a_conveyor",
                strip_case + "[[wall]]\npoint_m = [0, 0, 0]\nnormal = [0, 0, 1]\n",
                {},
                {"[wall[0]] is given beside [conveyor]"}},
        BadCase{"body_upside_down", hand_case, {"body[0].max_m=[1, 1, -1]"}, {"--set body[0].max_m", "max_m is not above min_m in z"}},
        BadCase{
            "body_thinner_than_a_particle", hand_case, {"body[1].max_m=[3, 3, 0.01]"}, {"less than the distance of particles, 0.125 m"}},
        BadCase{"body_outside_the_domain", hand_case, {"body[1].max_m=[3, 3, 7]"}, {"lies outside [domain]"}},
        BadCase{"body_in_the_obstacle", hand_case, {"obstacle.depth_m=1"}, {"reach into the obstacle"}},
        BadCase{"domain_upside_down", hand_case, {"domain.min_m=[6, -5, -1]"}, {"[domain] max_m is not above min_m in x"}},
        BadCase{"normal_zero", hand_case, {"wall[0].normal=[0, 0, 0.0]"}, {"normal = [0, 0, 0] has no direction"}},
        BadCase{"mast_wider_than_the_belt",
                window_case,
                {"obstacle.width_m=20.6"},
                {"obstacle] width_m = 20.6 is wider than the belt, 20.5 m"}},
        BadCase{"outlet_in_the_mast",
                window_case,
                {"conveyor.downstream_length_m=1.4"},
                {"downstream_length_m = 1.4 ends inside the obstacle"}},
        BadCase{"inlet_at_the_mast", window_case, {"conveyor.upstream_length_m=0.9"}, {"upstream_length_m = 0.9 leaves no room"}},
        BadCase{"flow_thinner_than_a_cell", window_case, {"numerics.cell_size_m=1.8"}, {"flow_height_m = 1.75 is less than one cell"}},
        BadCase{"froude_without_gravity", window_case, {"numerics.gravity_m_s2=0"}, {"froude_number = 3 makes a speed"}},
        BadCase{"other_format", window_case, {"format_version=2"}, {"format_version = 2 is out of range; give one of 1"}},
        BadCase{"single_bracket_body", single_bracket_case, {}, {"case.toml:3:", "body is a single table; write [[body]]"}},
        BadCase{"override_without_value", strip_case, {"numerics.cfl"}, {"--set numerics.cfl: not understood"}},
        BadCase{"override_beyond_the_last_body", hand_case, {"body[2].shape=box"}, {"there is no body[2]; the file has 2"}},
        BadCase{"override_without_index", hand_case, {"body.shape=box"}, {"body is repeated; give its number, e.g. body[0]"}},
        BadCase{"override_of_a_list_entry", hand_case, {"body[0]=3"}, {"only a whole key can be replaced"}},
        BadCase{"override_of_a_key_as_table", strip_case + "", {"output.duration_s.x=3"}, {"duration_s is no table"}},
        BadCase{
            "override_misspelt", strip_case, {"numerics.cell_siz_m=0.5"}, {"--set numerics.cell_siz_m=0.5: ", "did you mean cell_size_m?"}},
        BadCase{"override_two_values", strip_case, {"numerics.cfl=0.5\nx = 3"}, {"more than one value"}}),
    [](const auto& param) { return param.param.name; });

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
  for (const KeyInfo& key : schema_keys()) {
    for (const std::string& other : key.excludes) {
      SCOPED_TRACE(key.table + "." + key.name + " and " + other);
      const std::vector<std::string> both{key.table + "." + other + "=1", key.table + "." + key.name + "=1"};
      EXPECT_TRUE(reports(message_of(strip_case, both), "--set " + both[1], {key.name + " is given beside " + other, "leave one out"}));
      const std::vector<std::string> turned{both[1], both[0]};
      EXPECT_TRUE(reports(message_of(strip_case, turned), "--set " + both[1], {key.name + " is given beside " + other}));
      EXPECT_EQ(message_of(strip_case, {both[0]}), "");
      EXPECT_EQ(message_of(strip_case, {both[1]}), "");
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
  for (const KeyInfo& key : schema_keys()) {
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

TEST(Estimate, CountsTheParticlesOfTheScene) {
  const double tolerance = 1e-12;  // relative; a few multiplications
  const Case window = parse_case(strip_case, "case.toml", {"conveyor.feed=window", "conveyor.width_m=10"});
  EXPECT_NEAR(estimate(window).particles / (12.0 * 1.75 * 5.0 * 8 * 64), 1.0,
              tolerance);  // half of the window; 64 cells of 0.25 m in a m^3
  const Case strip = parse_case(strip_case, "case.toml", {"conveyor.width_m=10", "conveyor.velocity_m_s=2"});
  EXPECT_NEAR(estimate(strip).particles / ((2.0 * 6.0 + 3.0) * 1.75 * 5.0 * 8 * 64), 1.0, tolerance);
  const Case hand = parse_case(hand_case, "case.toml");
  EXPECT_NEAR(estimate(hand).particles / ((3.14159265358979324 * 4.0 / 2.0 + 1.0) * 8 * 64), 1.0, tolerance);
}

TEST(Estimate, KnowsTheFastestAndHighestInflow) {
  const auto of = [](const std::string& text, const std::vector<std::string>& sets) {
    return estimate(parse_case(text, "case.toml", sets));
  };
  const Estimate slow = of(surge_case, {}), fast = of(surge_case, {"conveyor.inflow[0].velocity_m_s=40"});
  EXPECT_NEAR(fast.time_step / of(surge_case, {"conveyor.velocity_m_s=40"}).time_step, 1.0, 1e-12);
  EXPECT_LT(fast.time_step, slow.time_step);
  const Estimate high = of(surge_case, {"conveyor.inflow[0].flow_height_m=3.5"});
  EXPECT_NEAR(high.particles / slow.particles, 3.5 / 1.75, 1e-12) << "the conveyor's own height is 1.75 m, the row's 1.5 m";
  // u(H) = v (s + (1 - s)(1 + n)): 2 v for s = 0.5, n = 2, and 1.5 v for n = 1
  const Estimate parabolic = of(sheared_case, {"conveyor.velocity_m_s=3"});
  const Estimate linear = of(sheared_case, {"conveyor.velocity_m_s=4", "conveyor.inflow_shear_exponent=1"});
  EXPECT_NEAR(parabolic.time_step / linear.time_step, 1.0, 1e-12);
}

TEST(Estimate, StepFollowsFromWaveSpeedAndCfl) {
  const Case c = parse_case(strip_case, "case.toml");
  const Estimate e = estimate(c);
  EXPECT_NEAR(e.wave_speed, 58.4, 0.05);  // physics of the paper's snow, as printed there
  EXPECT_LE(e.time_step, 0.4 * 0.25 / (e.wave_speed + c.conveyor->velocity));
  EXPECT_GE(e.steps * e.time_step, c.output.duration);
}

TEST(Estimate, RefusesWhatDoesNotFit) {
  const Estimate huge = estimate(parse_case(strip_case, "case.toml", {"numerics.cell_size_m=0.0001"}));
  EXPECT_THROW(require_memory(huge, physical_memory_bytes()), ConfigError);
  EXPECT_NO_THROW(require_memory(estimate(parse_case(strip_case, "case.toml")), 1e12));
}

}  // namespace
}  // namespace mpm
