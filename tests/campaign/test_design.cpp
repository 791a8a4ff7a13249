/// From a site file to an ensemble of runs.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/design_plan.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/campaign/site.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;

const std::string mast_site = R"(title = "Pylon"
[flow]
depth_m = 2.0
velocity_m_s = 14.0
density_kg_m3 = 250.0
slope_deg = 20.0
snow_class = "loose"
[mast]
shape = "cylinder"
width_m = 0.8
height_m = 12.0
[[mode]]
frequency_hz = 2.5
)";

Site site(const std::string& text = mast_site) { return parse_site(text, "site.toml"); }

/// A text with one part replaced.
std::string with(const std::string& from, const std::string& to) {
  std::string text = mast_site;
  text.replace(text.find(from), from.size(), to);
  return text;
}

std::string message_of(const std::string& text) {
  try {
    (void)site(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(SiteFile, GivesTheSiteWithItsDefaults) {
  const Site s = site();
  EXPECT_EQ(s.mast.shape, SiteMast::Shape::cylinder);
  EXPECT_EQ(s.mast.friction, 0.15);
  EXPECT_EQ(s.modes.size(), 1U);
  EXPECT_EQ(s.modes[0].damping_ratio, 0.02);
  EXPECT_NEAR(s.gravity(), 9.81 * std::cos(20.0 * std::numbers::pi / 180.0), 1e-12);
  EXPECT_NEAR(s.froude_number(), 14.0 / std::sqrt(s.gravity() * 2.0), 1e-12);
}

TEST(SiteFile, ReadsBackWhatItWrites) { EXPECT_EQ(site(write_site(site())), site()); }

TEST(SiteFile, TurnsAFroudeNumberIntoASpeed) {
  const Site s = site(with("velocity_m_s = 14.0", "froude_number = 3.0"));
  EXPECT_NEAR(s.froude_number(), 3.0, 1e-12);
  EXPECT_FALSE(s.flow.froude_number);
}

TEST(SiteFile, TakesADepthOfABoxEqualToItsWidth) { EXPECT_EQ(site(with("shape = \"cylinder\"", "shape = \"box\"")).mast.depth, 0.8); }

TEST(SiteFile, NamesWhatIsWrongWithPlaceValueAndRemedy) {
  EXPECT_THAT(message_of(with("depth_m = 2.0", "depth_n = 2.0")), HasSubstr("depth_m"));
  EXPECT_THAT(message_of(with("velocity_m_s = 14.0\n", "")), HasSubstr("give velocity_m_s, or froude_number"));
  EXPECT_THAT(message_of(with("snow_class = \"loose\"\n", "")), HasSubstr("says nothing about the snow"));
  EXPECT_THAT(message_of(with("\"loose\"", "\"powder\"")), HasSubstr("cold_dense"));
  EXPECT_THAT(message_of(with("slope_deg = 20.0", "slope_deg = 85.0")), HasSubstr("site.toml:6"));
  EXPECT_THAT(message_of(with("height_m = 12.0", "height_m = 0.1")), HasSubstr("lower than the flow"));
  EXPECT_THAT(message_of(with("width_m = 0.8", "width_m = 80.0")), HasSubstr("0.1 to 10 times"));
  EXPECT_THAT(message_of(with("width_m = 0.8", "depth_m = 1.0\nwidth_m = 0.8")), HasSubstr("depth_m")) << "a cylinder has none";
  EXPECT_THAT(message_of(mast_site + "[[snow]]\ncritical_state_slope = 0.5\ncohesion_beta = 0\nhardening_xi = 5\n"),
              HasSubstr("leave out one of the two"));
}

TEST(SiteFile, HasTwoNamesForWetDenseSnow) {
  EXPECT_EQ(site(with("\"loose\"", "\"wet_dense\"")), site(with("\"loose\"", "\"warm_cohesive\"")));
}

TEST(SiteFile, HoldsTheShapeOfAModeAtTheLoadAndItsOwner) {
  const Site s = site("author = \"A. Name\"\nproject = \"7\"\n" + mast_site + "shape_at_load = 0.02\n");
  EXPECT_EQ(s.modes[0].shape_at_load, 0.02);
  EXPECT_EQ(site(write_site(s)), s);
  const auto plan = nlohmann::json::parse(design_plan_json(make_design(s, DesignLevel::quick)));
  EXPECT_EQ(plan["modes"][0]["shape_at_load"], 0.02);
  EXPECT_EQ(plan["author"], "A. Name");
  EXPECT_TRUE(plan["mast"]["drag_coefficient"].is_null());
  EXPECT_THAT(message_of(mast_site + "shape_at_load = 2\n"), HasSubstr("shape_at_load"));
}

TEST(SiteFile, HoldsObliqueFlowSnowCoverBeamRangesAndScenariosAndHidesTheirDefaults) {
  std::string text = with("\"cylinder\"", "\"box\"\nangle_deg = 20\ntaper = 0.5\ntop_mass_ratio = 0.4");
  text.insert(text.find("snow_class"), "snow_cover_m = 1.5\nsource = \"300 years\"\n");
  const std::string scenario = "[[scenario]]\nname = \"100 years\"\ndepth_m = 2.5\nvelocity_m_s = 16\n";
  const Site s = site(text + "[range]\nvelocity_ratio = 0.1\n" + scenario);
  EXPECT_NEAR(s.mast.angle, 20.0 * std::numbers::pi / 180.0, 1e-12);
  EXPECT_NEAR(*s.exposed_height(), 10.5, 1e-12);
  EXPECT_EQ(s.range.velocity, 0.1);
  EXPECT_EQ(site(write_site(s)), s);
  const auto json = nlohmann::json::parse(design_plan_json(make_design(s, DesignLevel::quick)));
  EXPECT_EQ(json["scenarios"][0]["density_kg_m3"], 250.0) << "that of [flow]";
  EXPECT_EQ(json["range"]["depth_ratio"], 0.2);
  EXPECT_EQ(json["mast"]["top_mass_ratio"], 0.4);
  EXPECT_EQ(json["flow"]["snow_cover_m"], 1.5);
  EXPECT_EQ(json["flow"]["source"], "300 years");
  for (const char* key : {"angle_deg", "taper", "top_mass_ratio", "snow_cover_m", "[range]", "scenario"})
    EXPECT_THAT(write_site(site()), ::testing::Not(HasSubstr(key))) << "sites of before stay as they are";
  for (const auto& [right, wrong] : {std::pair{"angle_deg", "angel_deg"},
                                     {"taper", "tapper"},
                                     {"top_mass_ratio", "top_mass_ration"},
                                     {"snow_cover_m", "snow_cover"},
                                     {"velocity_ratio", "velocity_ration"},
                                     {"depth_m = 2.5", "depht_m = 2.5"}}) {
    std::string misspelt = text + "[range]\nvelocity_ratio = 0.1\n" + scenario;
    misspelt.replace(misspelt.find(right), std::string(right).size(), wrong);
    const std::string key = right;
    EXPECT_THAT(message_of(misspelt), HasSubstr(key.substr(0, key.find(' '))));
  }
  EXPECT_THAT(message_of(with("width_m = 0.8", "width_m = 0.8\nangle_deg = 10")), HasSubstr("angle_deg")) << "a cylinder has none";
  EXPECT_THAT(message_of(with("snow_class", "snow_cover_m = 10.5\nsnow_class")), HasSubstr("on its snow cover, 12.5 m"));
  EXPECT_THAT(message_of(mast_site + scenario + scenario + scenario + scenario), HasSubstr("at most 3"));
  EXPECT_THAT(message_of(mast_site + scenario + scenario), HasSubstr("scenario[1]] name = \"100 years\" is given twice"));
  EXPECT_THAT(message_of(mast_site + "[[scenario]]\nname = \"\"\ndepth_m = 2.5\nvelocity_m_s = 16\n"), HasSubstr("is no name"));
  const std::string mode = "[[mode]]\nfrequency_hz = 1.5\n";
  EXPECT_THAT(message_of(mast_site + mode + mode), HasSubstr("frequency_hz = 1.5 Hz is given twice"));
  EXPECT_THAT(message_of(mast_site + "[plan]\nfinest_cells = 5\ngrids = 3\n"), HasSubstr("below it there is only the grid of 3 cells"));
}

TEST(DesignPlans, RefuseOverridesOfTheSiteHoweverTheyAreWritten) {
  for (const char* text :
       {"conveyor.velocity_m_s=3", "conveyor.velocity_m_s =3", " material.density_kg_m3=500", "conveyor.inflow_csv=a.csv"})
    EXPECT_THROW(make_design(site(), DesignLevel::quick, {text}), ConfigError) << text;
}

TEST(SiteFile, ChecksEveryScenarioAgainstTheMast) {
  const auto scenario = [](double depth) {
    return mast_site + fmt::format("[[scenario]]\nname = \"rare\"\ndepth_m = {}\nvelocity_m_s = 30\n", depth);
  };
  EXPECT_NO_THROW(site(scenario(7.9)));
  EXPECT_THAT(message_of(scenario(13.0)), HasSubstr("height_m = 12 m is lower than the flow of scenario \"rare\", 13 m"));
  EXPECT_THAT(message_of(scenario(8.1)), HasSubstr("0.0988 times the depth of the flow of scenario \"rare\""));
}

TEST(SiteFile, TakesABoxOnItsSideForTheSameBody) {
  const auto box = [](const std::string& mast) {
    return make_design(site(with("shape = \"cylinder\"\nwidth_m = 0.8", mast) + "[plan]\nfinest_cells = 7\ngrids = 2\n"),
                       DesignLevel::quick);
  };
  const DesignPlan facing = box("shape = \"box\"\nwidth_m = 2\ndepth_m = 0.4"),
                   turned = box("shape = \"box\"\nwidth_m = 0.4\ndepth_m = 2\nangle_deg = 90");
  EXPECT_EQ(turned.site.mast.facing_width(), 2.0);
  ASSERT_EQ(turned.campaign.runs.size(), facing.campaign.runs.size());
  for (std::size_t i = 0; i < facing.campaign.runs.size(); ++i) {
    const Case &a = facing.campaign.runs[i].spec, &b = turned.campaign.runs[i].spec;
    EXPECT_EQ(a.numerics.cell_size, b.numerics.cell_size);
    EXPECT_EQ(a.obstacle->width(), b.obstacle->width());
    EXPECT_NEAR(a.conveyor->width, b.conveyor->width, 1e-9);
    EXPECT_NEAR(a.conveyor->upstream_length, b.conveyor->upstream_length, 1e-9);
    EXPECT_EQ(a.output.duration, b.output.duration);
  }
}

const std::string arm = "[arm]\nlength_m = 4\ndepth_m = 0.5\nbase_m = 3\nheight_m = 3.4\n";

TEST(SiteFile, HoldsAnArmWithTheKeysOfACase) {
  const Site s = site(mast_site + arm);
  EXPECT_EQ(s.arm->base, 3.0);
  EXPECT_EQ(site(write_site(s)), s);
  EXPECT_THAT(write_site(site()), ::testing::Not(HasSubstr("[arm]"))) << "sites of before stay as they are";
  for (const auto& p : parameters_of<ArmSpec>().all()) {
    EXPECT_NE(site_schema().find_key("arm", p.info.name), nullptr) << p.info.name;
    std::string misspelt = arm;
    misspelt.replace(misspelt.find(p.info.name), p.info.name.size(), p.info.name + "s");
    EXPECT_THAT(message_of(mast_site + misspelt), HasSubstr("did you mean " + p.info.name));
  }
}

TEST(SiteFile, ChecksAnArmAgainstTheMastAndTheSnowCoverAndNamesAllErrorsAtOnce) {
  const std::string wrong = "[arm]\nlength_m = 0.7\ndepth_m = 0.9\nbase_m = 12\nheight_m = 13\n";
  EXPECT_THAT(message_of(mast_site + wrong),
              AllOf(HasSubstr("[arm] length_m = 0.7 does not reach beyond the mast, 0.8 m"),
                    HasSubstr("depth_m = 0.9 reaches upstream of the mast, where the snow begins; give at most 0.8 m"),
                    HasSubstr("base_m = 12 is not below the top of the mast, 12 m")));
  EXPECT_THAT(message_of(with("width_m = 0.8\n", "") + wrong), ::testing::Not(HasSubstr("the mast"))) << "its size is not known";
  EXPECT_THAT(message_of(with("snow_class", "snow_cover_m = 3.5\nsnow_class") + arm),
              HasSubstr("[arm] base_m = 3 is in the snow cover, which reaches to 3.5 m"));
}

TEST(SiteFile, IsNamedWhereACaseIsExpected) {
  const auto file = std::filesystem::temp_directory_path() / "a_site_and_no_case.toml";
  std::ofstream(file) << mast_site;
  try {
    (void)read_case(file);
    ADD_FAILURE() << "a site was read as a case";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("this is a site file"));
  }
  std::filesystem::remove(file);
}

TEST(SiteFile, IsExpectedWhereACaseIsGiven) {
  const std::string text = "[conveyor]\nvelocity_m_s = 9\n[numerics]\ncell_size_m = 0.2\n[output]\nduration_s = 5\n";
  EXPECT_THAT(message_of(text), HasSubstr("this is a case file, not a site file; run `mpm run"));
  EXPECT_THAT(message_of(with("width_m = 0.8", "widht_m = 0.8")), HasSubstr("mpm schema --site")) << "a site file with an error stays one";
}

TEST(SiteFile, RefusesTwoSnowsOfOneNameAndNamesThatAreNoFolder) {
  const std::string own = with("snow_class = \"loose\"\n", "");
  const std::string snow = "[[snow]]\nname = \"a\"\ncritical_state_slope = 0.5\ncohesion_beta = 0\nhardening_xi = 5\n";
  EXPECT_EQ(message_of(own + snow), "");
  EXPECT_THAT(message_of(own + snow + snow),
              AllOf(HasSubstr("given twice"), HasSubstr("[snow[1]] has the parameters of an earlier entry; leave out one")));
  std::string path = snow;
  path.replace(path.find("\"a\""), 3, "\"a/b\"");
  EXPECT_THAT(message_of(own + path), HasSubstr("names no folder"));
}

TEST(SnowPresets, HaveTheEffectiveFrictionThatTheirSourceStates) {
  for (const auto& [name, low, middle, high] :
       {std::tuple{"loose", 0.45, 0.59, 0.65}, {"cold_dense", 1.0, 1.32, 1.5}, {"warm_cohesive", 1.0, 1.25, 1.5}}) {
    const auto snows = design_snows(site(with("\"loose\"", std::string("\"") + name + "\"")));
    ASSERT_EQ(snows.size(), 3U);
    const double expected[] = {low, middle, high};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(effective_friction(snows[i].critical_state_slope, snows[i].cohesion_beta), expected[i], 0.005)
          << "printed with two decimals";
      EXPECT_FALSE(snows[i].source.empty());
      EXPECT_EQ(snows[i].source.find("M' ="), std::string::npos) << "a number of its own, not part of the text";
    }
  }
  const SiteSnow loose = design_snows(site())[1];  // Sect. 4.3 of the paper
  EXPECT_NEAR(loose.critical_state_slope, 0.5, 1e-3);
  EXPECT_NEAR(100.0 * plastic_compressibility(loose.hardening_xi, 25e3, 10e3, bulk_modulus(1e6, 0.1)), 107.5, 0.05);
}

TEST(DesignPlans, CrossEverySnowWithGridsThatFitTheTimeOfTheLevel) {
  for (const DesignLevel level : {DesignLevel::quick, DesignLevel::standard}) {
    const DesignPlan plan = make_design(site(), level);
    EXPECT_EQ(plan.runs.size(), plan.snows.size() * plan.cells.size());
    EXPECT_LE(plan.particle_steps, design_budget(level));
    EXPECT_GE(plan.cells.size(), 2U);
    for (std::size_t g = 1; g < plan.cells.size(); ++g) EXPECT_GE(plan.cell_size[g - 1] / plan.cell_size[g], 1.3);
    std::set<std::string> names;
    for (std::size_t i = 0; i < plan.runs.size(); ++i) {
      EXPECT_EQ(plan.runs[i].name, plan.campaign.runs[i].name);
      names.insert(plan.runs[i].name);
    }
    EXPECT_EQ(names.size(), plan.runs.size());
  }
  EXPECT_GT(make_design(site(), DesignLevel::standard).cells.back(), make_design(site(), DesignLevel::quick).cells.back());
}

TEST(DesignPlans, HaveRunsOfTheSiteOnWholeCells) {
  const Site s = site();
  const DesignPlan plan = make_design(s, DesignLevel::quick);
  for (const CampaignRun& run : plan.campaign.runs) {
    const Case& c = run.spec;
    EXPECT_EQ(c.conveyor->velocity, 14.0);
    EXPECT_EQ(c.material.density(), 250.0);
    EXPECT_EQ(c.numerics.slope, 0.0) << "the bed holds the flow";
    EXPECT_NEAR(c.numerics.gravity, s.gravity(), 1e-12);
    EXPECT_EQ(c.obstacle->height, 12.0);
    EXPECT_GE(c.output.duration, 5.0 * 14.0 / s.gravity() - 1e-9) << "2 v/g for the splash and 3 v/g for means";
    for (const double length : {c.obstacle->width(), 0.5 * c.conveyor->width, c.conveyor->upstream_length, c.conveyor->downstream_length}) {
      const double cells = length / c.numerics.cell_size;
      EXPECT_NEAR(cells, std::round(cells), 1e-9) << length;
    }
    EXPECT_EQ(std::lround(c.obstacle->width() / c.numerics.cell_size) % 2, 1) << "odd";
    EXPECT_EQ(c.measurement.bin_height, plan.campaign.runs[0].spec.measurement.bin_height) << "the same windows on all grids";
  }
}

TEST(DesignPlans, ComputeTheWholeFlowAgainstATurnedMastAndTheMastAboveASnowCover) {
  std::string text = with("\"cylinder\"", "\"box\"");
  const Case before = make_design(site(text), DesignLevel::quick).campaign.runs[0].spec;
  EXPECT_TRUE(before.conveyor->mirror_y);
  text.insert(text.find("width_m"), "angle_deg = 30\n");
  text.insert(text.find("snow_class"), "snow_cover_m = 1.5\n");
  for (const CampaignRun& run : make_design(site(text), DesignLevel::quick).campaign.runs) {
    const Case& c = run.spec;
    EXPECT_FALSE(c.conveyor->mirror_y);
    EXPECT_NEAR(std::stod(case_value(c, "obstacle.rotation_deg").value()), 30.0, 1e-9);
    EXPECT_EQ(c.obstacle->height, 10.5);
    EXPECT_GT(c.conveyor->width, before.conveyor->width) << "1.1 m across instead of 0.8 m";
    const double cells = 0.5 * c.conveyor->width / c.numerics.cell_size;
    EXPECT_NEAR(cells, std::round(cells), 1e-9);
  }
}

TEST(DesignPlans, PutTheArmAboveTheSnowCoverIntoEveryRunAndKeepTheSideWallsAway) {
  const DesignPlan plan = make_design(site(with("snow_class", "snow_cover_m = 1.5\nsnow_class") + arm), DesignLevel::quick);
  for (const CampaignRun& run : plan.campaign.runs) {
    ASSERT_TRUE(run.spec.arm);
    EXPECT_EQ(run.spec.arm->length, 4.0);
    EXPECT_DOUBLE_EQ(run.spec.arm->base, 1.5);
    EXPECT_DOUBLE_EQ(run.spec.arm->height, 1.9);
    EXPECT_GE(run.spec.conveyor->width, 4.0 + 5.0 * std::sqrt(0.8 * 2.0)) << "2.5 r beside each end, r = sqrt(w H)";
  }
  const auto json = nlohmann::json::parse(design_plan_json(plan));
  EXPECT_EQ(json["arm"]["base_m"], 3.0) << "above the ground";
  EXPECT_FALSE(nlohmann::json::parse(design_plan_json(make_design(site(), DesignLevel::quick))).contains("arm"));
  const std::vector<DesignAdvice> advice = design_advice(plan);
  const auto thin = std::ranges::find(advice, "arm_base", &DesignAdvice::rule);
  ASSERT_NE(thin, advice.end());
  EXPECT_THAT(thin->text, AllOf(HasSubstr("cells between arm.base_m less flow.snow_cover_m and arm.height_m less"),
                                HasSubstr("take plan.finest_cells = 7 (three cells)")))
      << "0.4 m in three cells, six across the mast";
}

TEST(DesignPlans, KeepTheProgramsNumericsExceptTheStepAndTakeOverrides) {
  const DesignPlan plan = make_design(site(), DesignLevel::quick);
  EXPECT_EQ(plan.campaign.runs[0].spec.numerics.contact, Numerics{}.contact);
  EXPECT_EQ(plan.campaign.runs[0].spec.numerics.transfer, Numerics{}.transfer);
  EXPECT_EQ(plan.campaign.runs[0].spec.numerics.cfl, 1.0);
  const DesignPlan other = make_design(site(), DesignLevel::quick, {"numerics.cfl=0.3"});
  for (const CampaignRun& run : other.campaign.runs) EXPECT_EQ(run.spec.numerics.cfl, 0.3);
}

TEST(DesignPlans, CountCellsInTheDepthOfAFlowAgainstAWideMast) {
  const DesignPlan plan = make_design(site(with("width_m = 0.8", "width_m = 6.0")), DesignLevel::quick);
  for (std::size_t g = 0; g < plan.cells.size(); ++g) EXPECT_LE(plan.cell_size[g], 2.0 / plan.cells[g] + 1e-12);
}

TEST(DesignPlans, TakeTheGridsThatTheSiteAsksFor) {
  const DesignPlan plan = make_design(site(mast_site + "[plan]\nfinest_cells = 7\ngrids = 2\nduration_s = 6\n"), DesignLevel::quick);
  EXPECT_EQ(plan.cells, (std::vector{5, 7}));
  EXPECT_EQ(plan.campaign.runs[0].spec.output.duration, 6.0);
}

TEST(DesignPlans, AreCampaignPlansThatReadBack) {
  const DesignPlan plan = make_design(site(), DesignLevel::quick);
  const Campaign again = make_campaign(parse_plan(write_plan(plan.campaign.plan), "plan.toml"));
  ASSERT_EQ(again.runs.size(), plan.campaign.runs.size());
  for (std::size_t i = 0; i < again.runs.size(); ++i) EXPECT_EQ(again.runs[i].case_hash, plan.campaign.runs[i].case_hash);
}

TEST(DesignPlans, DescribeThemselvesForThePage) {
  const DesignPlan plan = make_design(site(), DesignLevel::quick);
  const std::string text = design_plan_json(plan);
  const auto json = nlohmann::json::parse(text);
  EXPECT_TRUE(is_intact(text));
  EXPECT_TRUE(json.contains(checksum_entry));
  EXPECT_EQ(json["level"], "quick");
  EXPECT_EQ(json["mast"]["shape"], "cylinder");
  EXPECT_EQ(json["snows"].size(), 3U);
  EXPECT_EQ(json["runs"].size(), json["snows"].size() * json["grids"].size());
  for (std::size_t r = 0; r < plan.runs.size(); ++r) {
    EXPECT_EQ(json["runs"][r]["case_hash"], plan.campaign.runs[r].case_hash);
    EXPECT_EQ(json["runs"][r]["end_s"], plan.duration);
  }
  EXPECT_EQ(json["modes"][0]["frequency_hz"], 2.5);
}

TEST(DesignPlans, ComeWithAdviceAboutTheFinestRunOfEachSnowAndEqualAdviceOnce) {
  const DesignPlan plan = make_design(site(), DesignLevel::quick);
  const std::vector<DesignAdvice> advice = design_advice(plan);
  const auto of = [&](const std::string& rule) { return std::ranges::find(advice, rule, [](const DesignAdvice& a) { return a.rule; }); };
  ASSERT_NE(of("mast_height"), advice.end());
  EXPECT_THAT(of("mast_height")->text, HasSubstr("mast.height_m = 12 m")) << "the key of the site file";
  EXPECT_THAT(of("mast_height")->text, HasSubstr("H + v^2/2g = 12.6 m")) << "2 m + 14^2 / (2 9.81 cos 20 deg) m, and the mast has 12 m";
  EXPECT_EQ(of("mast_height")->snows.size(), 3U);
  EXPECT_THAT(of("range_of_equations")->text, HasSubstr("w/H = 0.4"));
  EXPECT_EQ(of("cells_across"), advice.end()) << "three cells of the coarsest grid are meant";
  const auto json = nlohmann::json::parse(design_plan_json(plan));
  EXPECT_EQ(json["advice"].size(), advice.size());
  EXPECT_EQ(json["advice"][0]["snows"].size(), advice[0].snows.size());
}

TEST(DesignPlans, HaveNoAdviceAboutTheMachNumberAndShocksUnlessTheFlowIsFast) {
  const auto rules = [](const std::string& text) {
    std::set<std::string> names;
    for (const DesignAdvice& a : design_advice(make_design(site(text), DesignLevel::quick))) names.insert(a.rule);
    return names;
  };
  EXPECT_FALSE(rules(mast_site).contains("mach_number"));
  EXPECT_FALSE(rules(mast_site).contains("compaction_shock"));
  const std::string fast = with("velocity_m_s = 14.0", "velocity_m_s = 45.0");  // c_P 64.5 m/s; plastic compaction at xi = 0.5: 24 m/s
  EXPECT_TRUE(rules(fast).contains("mach_number"));
  EXPECT_TRUE(rules(fast).contains("compaction_shock"));
}

TEST(SiteReference, ListsEveryKeyWithoutLaws) {
  EXPECT_THAT(config::reference_text(site_reference()), HasSubstr("snow_class"));
  EXPECT_THAT(config::reference_text(site_reference()), ::testing::Not(HasSubstr("Laws")));
  EXPECT_EQ(nlohmann::json::parse(config::reference_json(site_reference()))["tables"].size(), site_schema().tables().size());
}

}  // namespace
}  // namespace mpm
