#include "libmpm/driver/run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/observers.hpp"

namespace mpm {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* mast_text =
    "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0\nhardening_xi = 5\n[conveyor]\nfroude_number = 3\n[obstacle]\n"
    "[output]\nduration_s = 8\n";

Case mast() { return parse_case(mast_text, "mast.toml"); }
Case with_arm() { return parse_case(std::string(mast_text) + "[arm]\nlength_m = 5\ndepth_m = 1\nbase_m = 3\nheight_m = 4\n", "mast.toml"); }

/// The results of a run with some values filled in.
Results results(const std::vector<std::pair<std::string, Value>>& values, const Case& c = mast()) {
  Results filled;
  for (Result r : expected_results(c).entries()) {
    for (const auto& [name, value] : values) {
      if (r.name == name) r.value = value;
    }
    filled.add(std::move(r));
  }
  return filled;
}

TEST(RunSummary, StatesWhatEveryPlusMinusContains) {
  const std::string text = summary_text(results({{"steady", true},
                                                 {"runup_mean_m", 7.23},
                                                 {"runup_standard_error_m", 0.05},
                                                 {"runup_numerical_uncertainty_m", 1.01},
                                                 {"force_mean_n", std::array{1.48e5, 0.0, 0.0}}}));
  EXPECT_THAT(text, HasSubstr("7.23 m     +- 0.05 (statistics) +- 1.01 (grid)"));
  EXPECT_THAT(text, HasSubstr("148 kN    +- unknown (statistics)"));
  EXPECT_THAT(text, HasSubstr("neither contains snow and model"));
  EXPECT_THAT(text, HasSubstr("about the mast's own axis"));
}

TEST(RunSummary, StatesWhichForceIsForDesign) {
  const std::string text = summary_text(results({{"steady", true},
                                                 {"force_mean_n", std::array{6.17e4, 0.0, 0.0}},
                                                 {"force_filtered_peak_n", 8.4e4},
                                                 {"force_filtered_peak_time_s", 0.2},
                                                 {"first_impact_until_s", 2.5},
                                                 {"inflow_constant_from_s", 0.0},
                                                 {"force_peak_n", 1.3e5}}));
  EXPECT_THAT(text, HasSubstr("filtered peak 84 kN"));
  EXPECT_THAT(text, HasSubstr("before the first splash has fallen back: it depends on the front): a peak of this run alone"));
  EXPECT_THAT(text, HasSubstr("steady mean 61.7 kN: the load while the avalanche passes"));
  EXPECT_THAT(text, HasSubstr("raw peak 130 kN"));
  EXPECT_THAT(text, HasSubstr("no design value"));
}

TEST(RunSummary, ShowsTheHighestParticleBesideTheRunup) {
  const std::string text = summary_text(results({{"steady", true}, {"runup_mean_m", 7.23}, {"runup_p99_mean_m", 5.5}}));
  EXPECT_THAT(text, HasSubstr("run-up                   5.5 m"));
  EXPECT_THAT(text, HasSubstr("highest particle        7.23 m"));
}

TEST(RunSummary, SaysThatThereIsNoMeanWithoutASteadyInterval) {
  EXPECT_THAT(summary_text(results({{"steady", false}})), HasSubstr("no steady interval"));
}

TEST(RunSummary, OffersNoLoadOfAFoundationFromTheTailOfASurge) {
  const std::string varies = summary_text(results({{"steady", false}, {"inflow_constant_from_s", 9.7}, {"duration_s", 8.0}}));
  EXPECT_THAT(varies, HasSubstr("the inflow at the obstacle varies until 9.7 s"));
  EXPECT_THAT(varies, Not(HasSubstr("take a longer")));
  const std::string tail =
      summary_text(results({{"steady", true}, {"inflow_constant_from_s", 9.7}, {"force_mean_n", std::array{6.17e4, 0.0, 0.0}}}));
  EXPECT_THAT(tail, HasSubstr("of the last row of the inflow, not of its strongest part"));
  EXPECT_THAT(tail, Not(HasSubstr("foundation")));
}

TEST(RunSummary, HasTheLoadsOfAnArm) {
  const std::string text = summary_text(results({{"steady", true},
                                                 {"arm_force_mean_n", std::array{1.29e4, 0.0, 3.1e3}},
                                                 {"arm_overturning_moment_mean_n_m", 3.26e4},
                                                 {"arm_force_filtered_peak_n", 2.2e4}},
                                                with_arm()));
  EXPECT_THAT(text, HasSubstr("arm, downstream         12.9 kN"));
  EXPECT_THAT(text, HasSubstr("arm, upwards             3.1 kN"));
  EXPECT_THAT(text, HasSubstr("arm, overturning        32.6 kN m"));
  EXPECT_THAT(text, HasSubstr("of the mast without its arm and of the arm, about the mast's own axis"));
  EXPECT_THAT(text, HasSubstr("filtered peak on the arm 22 kN downstream"));
  EXPECT_THAT(summary_text(results({{"steady", true}})), Not(HasSubstr("arm")));
}

TEST(RunSummary, WarnsOfAForceThatStillChanges) {
  EXPECT_THAT(result_warnings(results({{"force_drift", -0.12}, {"particles_final", std::uint64_t{1}}})),
              ElementsAre(HasSubstr("12 % of the mean lower")));
  EXPECT_TRUE(result_warnings(results({{"force_drift", 0.04}, {"particles_final", std::uint64_t{1}}})).empty());
}

TEST(RunSummary, IsEmptyForARunWithoutAnImpact) { EXPECT_EQ(summary_text(Results{}), ""); }

TEST(NumericalUncertainties, AreEntriesOfAnImpactThatComparisonsDoNotCompare) {
  const Results all = expected_results(mast());
  for (const char* name : {"runup_numerical_uncertainty_m", "pressure_height_numerical_uncertainty_m", "force_x_numerical_uncertainty_n",
                           "overturning_moment_numerical_uncertainty_n_m"}) {
    ASSERT_TRUE(all.has(name)) << name;
    EXPECT_EQ(all.find(name)->nature, Nature::uncertainty);
  }
}

TEST(GridResolutionOfACase, CountsCellsInTheSmallerOfWidthAndDepth) {
  Case c = mast();
  EXPECT_NEAR(grid_resolution(c).cells, 7.0, 1e-12);
  c.obstacle->as<BoxShape>().width = 7.0;
  EXPECT_NEAR(grid_resolution(c).cells, 7.0, 1e-12) << "H/dx";
}

TEST(GridResolutionOfACase, KnowsTheSnowThatConvergesSlowly) {
  Case c = mast();
  const auto traits = [&](double slope, double beta, double xi) {
    CamClay::Parameters snow;
    snow.critical_state_slope = slope, snow.cohesion_beta = beta, snow.hardening_xi = xi;
    c.material = snow;
    return grid_resolution(c).snow;
  };
  const SnowTraits none{}, fluid{.fluid = true}, sticky{.compressible_cohesive = true}, stiff{.stiff = true};
  EXPECT_EQ(traits(0.8, 0.3, 5.0), none);
  EXPECT_EQ(traits(0.8, 0.0, 0.5), none);
  EXPECT_EQ(traits(1.2, 0.15, 5.0), none) << "M' = 1.42";
  EXPECT_EQ(traits(0.8, 0.3, 0.5), sticky);
  EXPECT_EQ(traits(0.0, 0.3, 0.5), fluid);
  EXPECT_EQ(traits(0.8, 0.45, 5.0), stiff) << "M' = 1.53";
  EXPECT_EQ(traits(1.2, 0.3, 0.5), (SnowTraits{.compressible_cohesive = true, .stiff = true}));
  EXPECT_EQ(snow_traits(WeaklyCompressibleFluid::Parameters()), fluid);
  EXPECT_EQ(snow_traits(DruckerPrager::Parameters()), none);
}

}  // namespace
}  // namespace mpm
