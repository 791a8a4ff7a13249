#include "libmpm/driver/advice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/driver/case_file.hpp"
#include "support/ground.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;

/// The paper's mast at Fr 3 on seven cells for 8 s, about which there is nothing to say; further overrides change it.
std::vector<Advice> advice(const std::vector<std::string>& overrides, const char* obstacle = "") {
  const std::string text = std::string(R"(
[material]
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
froude_number = 3.0
window_size = "paper"
[obstacle]
friction = 0.15
)") + obstacle + R"(
[output]
duration_s = 8.0
)";
  return advise(parse_case(text, "case.toml", overrides));
}

/// The names of the rules that have something to say.
std::vector<std::string> rules(const std::vector<std::string>& overrides, const char* obstacle = "") {
  std::vector<std::string> names;
  for (const Advice& a : advice(overrides, obstacle)) names.push_back(a.rule);
  return names;
}

/// What a rule says.
Advice of(const std::string& rule, const std::vector<std::string>& overrides, const char* obstacle = "") {
  const auto all = advice(overrides, obstacle);
  const auto found = std::ranges::find(all, rule, &Advice::rule);
  return found == all.end() ? Advice{} : *found;
}

using Names = std::vector<std::string>;

TEST(AdviceAboutACase, IsSilentAboutThePapersMast) { EXPECT_EQ(rules({}), Names{}); }

TEST(AdviceAboutACase, IsSilentWithoutAConveyorOrAnObstacle) {
  EXPECT_TRUE(advise(parse_case("[material]\nmodel = \"hencky_elastic\"\n[[body]]\nshape = \"box\"\nmin_m = [0, 0, 0]\nmax_m = [1, 1, 1]\n"
                                "[domain]\nmin_m = [-1, -1, -1]\nmax_m = [2, 2, 2]\n[output]\nduration_s = 1\n",
                                "box.toml"))
                  .empty());
}

TEST(AdviceAboutACase, SaysWhereTheRunEndsIfNotWhereItWasAsked) {
  EXPECT_THAT(of("end_between_rows", {"output.duration_s=8.01"}).why, HasSubstr("ends with the next row, at 8.02 s"));
  EXPECT_THAT(of("end_between_rows", {"output.series_per_second=0.73"}).why, HasSubstr("at 8.21917808 s")) << "6 rows of 1/0.73 s";
  EXPECT_EQ(rules({"output.duration_s=7.94"}), Names{}) << "397 rows of 1/50 s, to round-off";
}

TEST(AdviceAboutACase, WarnsOfAnObstacleThinnerThanACell) {
  EXPECT_THAT(of("thin_obstacle", {"obstacle.depth_m=0.1"}).what, HasSubstr("0.4 cells across the thinnest part"));
  EXPECT_EQ(of("thin_obstacle", {"obstacle.depth_m=0.25"}).rule, "") << "one cell";
  EXPECT_THAT(of("thin_obstacle", {"obstacle.width_m=0.2"}, "shape = \"cylinder\"\n").remedy, HasSubstr("cell_size_m = 0.2"));
}

TEST(AdviceAboutACase, SaysHowManyFramesAreStored) {
  EXPECT_THAT(of("frames_between_rows", {"output.frames_per_second=30"}).why, HasSubstr("25 frames a second are stored"));
  EXPECT_THAT(of("frames_between_rows", {"output.frames_per_second=100"}).why, HasSubstr("50 frames a second are stored"));
  EXPECT_EQ(of("frames_between_rows", {"output.frames_per_second=10"}).rule, "");
}

/// What a rule says of an inflow with rows at these times.
std::string with_rows(const std::string& rule, const std::string& first, const std::string& second) {
  const std::string text =
      "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0.0\nhardening_xi = 5.0\n[conveyor]\nvelocity_m_s = 12.0\n"
      "[[conveyor.inflow]]\ntime_s = " +
      first + "\nvelocity_m_s = 8.0\n[[conveyor.inflow]]\ntime_s = " + second +
      "\nvelocity_m_s = 12.0\n[obstacle]\n[output]\nduration_s = 8.0\n";
  const auto all = advise(parse_case(text, "case.toml"));
  const auto found = std::ranges::find(all, rule, &Advice::rule);
  return found == all.end() ? std::string() : found->text();
}

TEST(AdviceAboutACase, SaysThatRowsOfTheInflowAreAfterTheEnd) {
  EXPECT_EQ(with_rows("inflow_after_the_end", "0.0", "7.0"), "");
  EXPECT_THAT(with_rows("inflow_after_the_end", "0.0", "9.0"), HasSubstr("1 of 2 rows"));
  EXPECT_THAT(with_rows("inflow_after_the_end", "1042.0", "1043.0"), HasSubstr("only the first is used"));
}

TEST(AdviceAboutACase, WarnsOfFewCellsAcrossTheObstacleAndGivesTheCellSize) {
  const Advice a = of("cells_across", {"numerics.cell_size_m=0.5833333333"});
  EXPECT_THAT(a.what, HasSubstr("3 cells across the obstacle"));
  EXPECT_THAT(a.remedy, HasSubstr("0.35")) << "1.75 m / 5";
  EXPECT_EQ(of("cells_across", {"numerics.cell_size_m=0.35"}).rule, "") << "five are enough";
}

TEST(AdviceAboutACase, CountsTheCellsInTheDepthOfAFlowAgainstAWideObstacle) {
  const Advice a = of("cells_across", {"obstacle.width_m=10", "conveyor.downstream_length_m=20", "numerics.cell_size_m=0.5"});
  EXPECT_THAT(a.what, HasSubstr("in the flow height"));
}

TEST(AdviceAboutACase, WarnsOfAnEvenNumberOfCellsWithNodalContactOnly) {
  const Names even{"numerics.cell_size_m=0.2916666666666667", "numerics.contact=nodal"};  // w/6
  EXPECT_THAT(of("nodal_width", even).why, HasSubstr("1.17 times")) << "7 rows of nodes for 6 cells";
  EXPECT_EQ(of("nodal_width", {even[0], "numerics.contact=surface"}).rule, "");
  EXPECT_EQ(of("nodal_width", {even[1]}).rule, "") << "7 cells";
  EXPECT_EQ(of("nodal_width", even, "shape = \"cylinder\"\n").rule, "") << "a circle has no sides along the grid";
}

TEST(AdviceAboutACase, WarnsOfARunThatEndsBeforeTheSplashIsBack) {
  const Advice a = of("splash_and_duration", {"output.duration_s=3.7"});  // 3 v/g = 3.80 s
  EXPECT_THAT(a.what, HasSubstr("2 v/g = 2.53 s"));
  EXPECT_THAT(a.remedy, HasSubstr("duration_s = 6 s"));
  EXPECT_EQ(of("splash_and_duration", {"output.duration_s=3.9"}).rule, "");
}

TEST(AdviceAboutACase, WarnsOfAStripThatThinsTooEarlyForAMean) {
  const Advice a = of("splash_and_duration", {"conveyor.feed=strip", "output.duration_s=4"});  // (v t + 3 m)/(v + sqrt(g H)): 3.18 s
  EXPECT_THAT(a.what, HasSubstr("not thinned from its rear for 3.18 s"));
  EXPECT_THAT(a.remedy, HasSubstr("duration_s = 7 s"));
  EXPECT_EQ(of("splash_and_duration", {"conveyor.feed=strip", "output.duration_s=7"}).rule, "");
}

TEST(AdviceAboutACase, WarnsOfMeansOfAnInflowThatVaries) {
  EXPECT_THAT(with_rows("inflow_varies", "0.0", "7.0"),
              AllOf(HasSubstr("varies until 7.58 s"), HasSubstr("are of the last row")));  // 7 m at 12 m/s
  EXPECT_THAT(with_rows("inflow_varies", "0.0", "9.0"), HasSubstr("of which there will be none"));
}

TEST(AdviceAboutACase, WarnsOfASlowFlowThatHasNotPassed) {
  const Names slow{"conveyor.froude_number=0.3"};  // 1.24 m/s: 14 H = 24.5 m take 19.7 s
  EXPECT_THAT(of("flow_passage", slow).remedy, HasSubstr("duration_s = 20 s"));
  EXPECT_EQ(of("flow_passage", {slow[0], "output.duration_s=20"}).rule, "");
  EXPECT_EQ(rules({"output.duration_s=1"}), Names{"splash_and_duration"}) << "one remedy for the duration, the longer one";
}

TEST(AdviceAboutACase, WarnsOfAFastFlowOfSoftSnow) {
  EXPECT_EQ(of("mach_number", {"conveyor.froude_number=7"}).rule, "") << "the paper's fastest, 29 m/s over 58.4 m/s";
  EXPECT_THAT(of("mach_number", {"conveyor.froude_number=3", "material.young_modulus_pa=1e5"}).what, HasSubstr("v/c_P = 0.673"));
}

TEST(AdviceAboutACase, WarnsOfAStiffnessInTheWrongUnit) {
  EXPECT_THAT(of("wave_speed", {"material.young_modulus_pa=1000"}).remedy, HasSubstr("is in Pa"));
  EXPECT_THAT(of("wave_speed", {"material.young_modulus_pa=1e9"}).why, HasSubstr("32 times shorter")) << "sqrt(1000)";
}

TEST(AdviceAboutACase, WarnsOfAShockThatRunsToTheInlet) {
  EXPECT_EQ(of("compaction_shock", {"material.hardening_xi=0.05"}).what.substr(0, 12), "v = 12.4 m/s");  // against 8.1 m/s
}

TEST(AdviceAboutACase, GivesTheSpeedThatASlopeAddsAndHowToKeepIt) {
  const Advice a = of("slope", {"numerics.slope_deg=20"});
  // sqrt(12.43^2 + 2 9.81 sin 20 deg 8) = 14.4 m/s over the 8 m of the window; 9.81 cos 20 deg = 9.22 m/s^2
  EXPECT_THAT(a.why, HasSubstr("14.4 m/s"));
  EXPECT_THAT(a.remedy, HasSubstr("gravity_m_s2 = 9.22"));
  EXPECT_THAT(of("slope", {"numerics.slope_deg=85"}).why, HasSubstr("Schweizer"));
}

TEST(AdviceAboutACase, NamesWhatThePapersEquationsWereNotFittedTo) {
  EXPECT_THAT(of("range_of_equations", {}, "shape = \"cylinder\"\n").what, HasSubstr("the shape"));
  EXPECT_THAT(of("range_of_equations", {"obstacle.width_m=0.7"}).what, HasSubstr("w/H = 0.4 (simulated: 0.5 to 3)"));
  EXPECT_THAT(of("range_of_equations", {"conveyor.froude_number=8"}).what, HasSubstr("Fr = 8"));
}

TEST(AdviceAboutACase, WarnsOfAMastThatIsLowerThanTheFlowTheRunupOrBernoullisBound) {
  EXPECT_THAT(of("mast_height", {"obstacle.height_m=0.1"}).what, HasSubstr("lower than the flow"));
  EXPECT_THAT(of("mast_height", {"obstacle.height_m=3"}).what, HasSubstr("lower than the run-up"));
  EXPECT_THAT(of("mast_height", {"obstacle.height_m=9.6"}).what, HasSubstr("H + v^2/2g = 9.62 m"));  // 1.75 m (1 + 3^2/2) = 9.625 m
  EXPECT_EQ(of("mast_height", {"obstacle.height_m=9.7"}).rule, "");
}

TEST(AdviceAboutACase, WarnsOfAnObstacleAboveTheGroundThatIsThinOrOutOfReach) {
  EXPECT_EQ(of("obstacle_base", {"obstacle.height_m=1"}).rule, "");
  EXPECT_EQ(of("obstacle_base", {"obstacle.base_m=2", "obstacle.height_m=3"}).rule, "");
  EXPECT_THAT(of("obstacle_base", {"obstacle.base_m=2", "obstacle.height_m=2.5"}).what, HasSubstr("2 cells between"));
  EXPECT_THAT(of("obstacle_base", {"obstacle.base_m=0.5", "obstacle.height_m=3"}).what, HasSubstr("2 cells between the ground"));
  EXPECT_THAT(of("obstacle_base", {"obstacle.base_m=9.7"}).what, HasSubstr("Bernoulli's bound"));
  EXPECT_EQ(of("mast_height", {"obstacle.base_m=1", "obstacle.height_m=3"}).rule, "") << "snow is meant to pass it";
  EXPECT_THAT(of("range_of_equations", {"obstacle.base_m=1"}).what, HasSubstr("above the ground"));
}

TEST(AdviceAboutACase, WarnsOfAnArmThatIsThinOrAboveTheRunUp) {
  const auto arm = [](const std::string& base, const std::string& height) {
    return of("arm_base", {"arm.length_m=4", "arm.depth_m=1", "arm.base_m=" + base, "arm.height_m=" + height});
  };
  EXPECT_EQ(arm("2.125", "3.125").rule, "");
  EXPECT_EQ(arm("0", "1").rule, "") << "it stands on the ground";
  EXPECT_THAT(arm("2", "2.5").what, HasSubstr("2 cells between arm.base_m and arm.height_m"));
  EXPECT_THAT(arm("9.625", "10.875").what, HasSubstr("arm.base_m = 9.62 m is above Bernoulli's bound"));
}

TEST(AdviceAboutACase, WarnsOfAWindowSmallerThanThoseThatWereChecked) {
  EXPECT_THAT(of("size_of_the_window", {"conveyor.upstream_length_m=5"}).what, HasSubstr("upstream_length_m = 5 (4 w = 7)"));
  for (const char* const shape : {"box", "cylinder", "wedge"}) {
    const std::vector<std::string> by_default{"conveyor.window_size=compact", std::string("obstacle.shape=") + shape};
    EXPECT_EQ(of("size_of_the_window", by_default).rule, "") << shape << ": the program's own window";
  }
}

TEST(AdviceAboutACase, WarnsOfStiffSlowSnowNearTheInlet) {
  const std::vector<std::string> stiff{"material.critical_state_slope=1.2", "material.cohesion_beta=0.45"};  // M' = 2.3
  const auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> all = stiff;
    all.insert(all.end(), more);
    return of("jam_at_the_inlet", all);
  };
  EXPECT_THAT(with({}).what, HasSubstr("M' = 2.3 with conveyor.upstream_length_m = 8"));
  EXPECT_THAT(with({}).remedy, HasSubstr("9.6 w = 16.8 m, and downstream_length_m = 8.4"));
  EXPECT_EQ(with({"conveyor.upstream_length_m=16.8"}).rule, "");
  EXPECT_EQ(with({"conveyor.froude_number=5"}).rule, "");
  EXPECT_EQ(of("jam_at_the_inlet", {"material.critical_state_slope=1.2", "material.cohesion_beta=0.3"}).rule, "") << "M' = 1.76";
}

TEST(AdviceAboutACase, WarnsOfValuesThatNoAvalancheHas) {
  EXPECT_THAT(of("plausible_values", {"material.density_kg_m3=0.3e4"}).what, HasSubstr("density_kg_m3 = 3e+03"));
  EXPECT_THAT(of("plausible_values", {"conveyor.velocity_m_s=50"}).what, HasSubstr("Froude number = ")) << "km/h";
  EXPECT_THAT(of("plausible_values", {"obstacle.friction=5"}).what, HasSubstr("obstacle.friction = 5"));
}

TEST(AdviceAboutACase, WarnsOfRowsTooFarApartForTheForceWindow) {
  EXPECT_THAT(of("rows_in_force_window", {"output.series_per_second=10"}).remedy, HasSubstr("series_per_second = 50"));
}

constexpr double pi = std::numbers::pi;

/// Advice about a block of 1 m on ground h(x, y), whose raster is four times finer than the grid of 0.25 m.
template <class F>
std::vector<Advice> advice_on_ground(F&& h, double dx = 0.25) {
  Case c = parse_case(
      "[material]\nmodel = \"hencky_elastic\"\n[[body]]\nmin_m = [0, 0, 0]\nmax_m = [1, 1, 1]\n"
      "[domain]\nmin_m = [-3, -3, -1]\nmax_m = [3, 3, 2]\n[output]\nduration_s = 1\n",
      "box.toml");
  c.numerics.cell_size = dx;
  c.terrain = testing::ground_spec(h, 4.0, 0.0625);
  return advise(c);
}

/// A wave along x with this greatest slope. @param length  cells of 0.25 m
auto wave(double length, double slope) {
  return [=](double x, double) { return slope / (2.0 * pi / (0.25 * length)) * std::cos(2.0 * pi * x / (0.25 * length)); };
}

TEST(AdviceAboutACase, WarnsOfGroundWithWavesOfAFewCells) {
  const auto found = advice_on_ground(wave(1.0, 0.5));  // all nodes see the same ground
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].rule, "short_waves_of_the_ground");
  EXPECT_THAT(found[0].what, HasSubstr("differs by up to 0.398 from its mean over two cells"))
      << "four points a wave: 1.25/(pi/2) of its slope";
  EXPECT_THAT(found[0].remedy, HasSubstr("means over 1 m, or take numerics.cell_size_m = 0.0156"));
  EXPECT_TRUE(advice_on_ground(wave(1.0, 0.5), 0.0625 / 4.0).empty()) << "the remedy";
  EXPECT_EQ(advice_on_ground(wave(3.0, 0.168)).size(), 1U) << "8 % of the speed of a slab";
  const auto checkers = [](double x, double y) { return std::lround((x + y) / 0.0625) % 2 == 0 ? 0.003 : -0.003; };
  EXPECT_EQ(advice_on_ground(checkers).size(), 1U) << "level at the points of the raster";
}

TEST(AdviceAboutACase, WarnsOfGroundThatIsNotAtZeroWhereTheObstacleStands) {
  Case c = parse_case(
      "[material]\nmodel = \"hencky_elastic\"\n[[body]]\nmin_m = [-2, -1, 3]\nmax_m = [-1, 1, 4]\n[obstacle]\nwidth_m = 1\n"
      "[domain]\nmin_m = [-3, -3, -1]\nmax_m = [3, 3, 5]\n[output]\nduration_s = 1\n",
      "box.toml");
  c.terrain = testing::ground_spec([](double, double) { return 2.0; }, 4.0, 0.5);
  const auto found = advise(c);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].rule, "ground_at_the_obstacle");
  EXPECT_THAT(found[0].remedy, HasSubstr("subtract 2 m"));
  c.terrain = testing::ground_spec([](double, double) { return 0.1; }, 4.0, 0.5);
  EXPECT_TRUE(advise(c).empty());
}

TEST(AdviceAboutACase, NamesThePlaceOfTheShortestWavesInTheDomain) {
  const auto step = [](double x, double y) { return 0.05 * std::tanh((x - 1.03125) / 0.1) * std::exp(-2.0 * std::pow(y + 2.0, 2)); };
  const auto found = advice_on_ground(step);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].what, HasSubstr("most at x = 1.03, y = -2"));
  const auto outside = [&](double x, double y) { return step(x - 2.75, y); };  // at x = 3.78
  EXPECT_TRUE(advice_on_ground(outside).empty()) << "beyond the domain";
}

TEST(AdviceAboutACase, IsSilentAboutSmoothGroundHoweverFineItsRaster) {
  EXPECT_TRUE(advice_on_ground([](double x, double y) { return 0.5 * x - 0.3 * y; }).empty());
  EXPECT_TRUE(advice_on_ground(wave(8.0, std::tan(pi / 6.0))).empty()) << "the steepest of a case";
  EXPECT_TRUE(advice_on_ground(wave(2.0, 0.05)).empty()) << "hardly a slope";
}

TEST(AdviceAboutACase, SaysWhatWhyAndTheRemedyInOneLine) {
  for (const Advice& a : advice({"numerics.cell_size_m=0.6", "output.duration_s=1", "numerics.slope_deg=85", "obstacle.height_m=0.1"})) {
    EXPECT_FALSE(a.what.empty() || a.why.empty() || a.remedy.empty()) << a.rule;
    EXPECT_EQ(a.text(), a.what + ": " + a.why + "; " + a.remedy);
    EXPECT_EQ(a.text().find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace mpm
