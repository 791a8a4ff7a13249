#include "libmpm/campaign/plan.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "libmpm/io/atomic_file.hpp"
#include "support/temporary_directory.hpp"
#include "support/text.hpp"

namespace mpm {
namespace {

using testing::contains;

constexpr const char* inline_base = R"([base.material]
model = "hencky_elastic"
[[base.body]]
min_m = [0.0, 0.0, 0.0]
max_m = [1.0, 1.0, 1.0]
)";

std::vector<std::string> names_of(const CampaignPlan& plan) {
  std::vector<std::string> names;
  for (const PlannedRun& run : plan.runs) names.push_back(run.name);
  return names;
}

std::map<std::string, std::string> values_of(const PlannedRun& run) {
  std::map<std::string, std::string> values;
  for (const Setting& s : run.settings) values[s.key] = s.value;
  return values;
}

CampaignPlan plan_of(const std::string& text) { return parse_plan(text + "\n" + inline_base, "plan.toml"); }

/// The message of the ConfigError that a plan ends in.
std::string refusal(const std::string& text, const std::string& base = inline_base) {
  try {
    (void)parse_plan(text + "\n" + base, "plan.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CampaignPlan, CrossesListsInTheOrderGivenTheLastFastest) {
  const CampaignPlan plan = plan_of(R"(title = "T"
[parameters]
"material.hardening_xi" = [5, 0.5]
"conveyor.froude_number" = [3.0, 1]
)");
  EXPECT_EQ(names_of(plan), (std::vector<std::string>{"xi5_fr3", "xi5_fr1", "xi0.5_fr3", "xi0.5_fr1"}));
  EXPECT_EQ(plan.runs[2].settings, (std::vector<Setting>{{"material.hardening_xi", "0.5"}, {"conveyor.froude_number", "3.0"}}));
  EXPECT_EQ(plan.title, "T");
  EXPECT_EQ(plan.threads, 1);
  EXPECT_FALSE(plan.keep_frames || plan.keep_final || plan.keep_checkpoint);
}

TEST(CampaignPlan, TakesJoinedKeysTogether) {
  const CampaignPlan plan = plan_of(R"([parameters]
"material.critical_state_slope, material.cohesion_beta" = [[0.4, 0.0], [0.8, 0.3]]
"obstacle.friction" = [0, 0.15]
)");
  EXPECT_EQ(names_of(plan), (std::vector<std::string>{"m0.4_beta0_mu0", "m0.4_beta0_mu0.15", "m0.8_beta0.3_mu0", "m0.8_beta0.3_mu0.15"}));
  EXPECT_EQ(values_of(plan.runs[3]).at("material.cohesion_beta"), "0.3");
}

TEST(CampaignPlan, InnerSettingsWinOverOuterOnes) {
  const CampaignPlan plan = plan_of(R"([set]
"output.duration_s" = 1
"numerics.cfl" = 0.3
[[when]]
match = { "conveyor.froude_number" = [3, 5] }
set = { "output.duration_s" = 2 }
[[when]]
match = { "conveyor.froude_number" = 5.0, "material.model" = "hencky_elastic" }
set = { "output.duration_s" = 3 }
[[grid]]
name = "a"
parameters = { "conveyor.froude_number" = [1, 3, 5] }
[[grid]]
name = "b"
set = { "output.duration_s" = 4 }
parameters = { "conveyor.froude_number" = [1, 3] }
when = [{ match = { "conveyor.froude_number" = 3 }, set = { "output.duration_s" = 5 } }]
[[run]]
name = "own"
set = { "conveyor.froude_number" = 3, "output.duration_s" = 6 }
)");
  std::map<std::string, std::string> duration;
  for (const PlannedRun& run : plan.runs) {
    duration[run.name] = values_of(run).at("output.duration_s");
    EXPECT_EQ(values_of(run).at("numerics.cfl"), "0.3");
  }
  EXPECT_EQ(duration, (std::map<std::string, std::string>{
                          {"a_fr1", "1"}, {"a_fr3", "2"}, {"a_fr5", "3"}, {"b_fr1", "4"}, {"b_fr3", "5"}, {"own", "6"}}));
}

TEST(CampaignPlan, RefusesRulesThatMatchNoRun) {
  const auto with_rule = [](const std::string& match, const std::string& in_grid = "") {
    return fmt::format(
        "[[when]]\nmatch = {{ {} }}\nset = {{ \"output.duration_s\" = 2 }}\n[[grid]]\nname = \"g\"\n"
        "parameters = {{ \"conveyor.froude_number\" = [1, 3] }}\n{}",
        match, in_grid);
  };
  EXPECT_EQ(plan_of(with_rule("\"conveyor.froude_number\" = 3.0")).runs.size(), 2U);
  EXPECT_TRUE(contains(refusal(with_rule("\"conveyor.froude_number\" = \"3\"")), "[[when]] 1 matches no run"));
  EXPECT_TRUE(contains(refusal(with_rule("\"numerics.cfl\" = 1.0")), "plan.toml:1: [[when]] 1 matches no run"));
  const std::string both = refusal(with_rule("\"numerics.cfl\" = 1.0") + "set = { \"numerics.cfl\" = -1.0 }\n[[when]]\n" +
                                   "match = { \"numerics.slope_deg\" = 7 }\nset = { \"numerics.cfl\" = 0.2 }\n");
  EXPECT_TRUE(contains(both, "[[when]] 1 matches no run")) << both;
  EXPECT_TRUE(contains(both, "[[when]] 2 matches no run")) << both;
  EXPECT_TRUE(contains(both, "numerics.cfl")) << "the errors of the cases, too: " << both;
  EXPECT_EQ(
      plan_of(with_rule("\"numerics.grid_offset_cells\" = [[0, 0, 0.5]]", "set = { \"numerics.grid_offset_cells\" = [0.0, 0.0, 0.5] }\n"))
          .runs.front()
          .settings.size(),
      3U);
  EXPECT_TRUE(contains(refusal("[base.conveyor]\nfroude_number = 3.0\n[[when]]\nmatch = { \"conveyor.froude_number\" = 3 }\n"
                               "set = { \"numerics.cfl\" = 0.3 }\n[[run]]\nset = { \"conveyor.velocity_m_s\" = 4.0 }\n"),
                       "[[when]] 1 matches no run"));
  const std::string rule = "when = [{ match = { \"conveyor.froude_number\" = 5 }, set = { \"numerics.cfl\" = 0.3 } }]\n";
  EXPECT_TRUE(contains(refusal(with_rule("\"conveyor.froude_number\" = 3", rule)), "[[grid]] 1 [[when]] 1 matches no run"));
}

TEST(CampaignPlan, RefusesTwoKeysOfOneQuantityInOnePlace) {
  const std::string two = "conveyor.velocity_m_s and conveyor.froude_number set the same quantity; give one of them";
  EXPECT_TRUE(contains(refusal("[[run]]\nset = { \"conveyor.velocity_m_s\" = 4.0, \"conveyor.froude_number\" = 1 }\n"), two));
  EXPECT_TRUE(contains(refusal("[parameters]\n\"conveyor.velocity_m_s\" = [4.0]\n\"conveyor.froude_number\" = [1]\n"), two));
  EXPECT_TRUE(contains(refusal("[lists.speeds]\nslow = { \"conveyor.velocity_m_s\" = 4.0 }\n"
                               "[parameters]\nspeed = \"speeds\"\n\"conveyor.froude_number\" = [1]\n"),
                       two));
  EXPECT_TRUE(contains(refusal("[[run]]\nset = { \"numerics.cfl\" = 0.4, numerics.cfl = 0.3 }\n"), "numerics.cfl is given twice"));
}

TEST(CampaignPlan, OneOfFroudeNumberAndVelocityReplacesTheOther) {
  const CampaignPlan plan = plan_of(R"([set]
"conveyor.velocity_m_s" = 4.0
[parameters]
"conveyor.froude_number" = [1]
)");
  EXPECT_EQ(plan.runs[0].settings, (std::vector<Setting>{{"conveyor.froude_number", "1"}}));
}

TEST(CampaignPlan, NamesAreFitForFolders) {
  const CampaignPlan plan = plan_of(R"([labels]
"numerics.cfl" = "C"
[parameters]
"material.model" = ["hencky_elastic", "a/b c"]
"numerics.cfl" = [0.40]
"domain.min_m" = [[-5.0, 0.0, 1e-3]]
"numerics.slope_deg" = [-3]
)");
  EXPECT_EQ(names_of(plan),
            (std::vector<std::string>{"hencky_elastic_C0.4_min_m-5.0-0.0-0.001_slope-3", "a-b-c_C0.4_min_m-5.0-0.0-0.001_slope-3"}));
}

TEST(CampaignPlan, ReadsExplicitRowsFromATable) {
  const testing::TemporaryDirectory directory;
  std::ofstream(directory / "rows.csv") << "name,numerics.cfl,material.model\nfirst,0.4,hencky_elastic\n,0.2,\n";
  const CampaignPlan plan = parse_plan(std::string("table = \"rows.csv\"\n") + inline_base, directory / "plan.toml");
  EXPECT_EQ(names_of(plan), (std::vector<std::string>{"first", "cfl0.2"}));
  EXPECT_EQ(plan.runs[0].settings, (std::vector<Setting>{{"numerics.cfl", "0.4"}, {"material.model", "\"hencky_elastic\""}}));
  EXPECT_EQ(plan.runs[1].settings, (std::vector<Setting>{{"numerics.cfl", "0.2"}}));
}

TEST(CampaignPlan, TakesItsBaseFromAFileBesideIt) {
  const testing::TemporaryDirectory directory;
  std::ofstream(directory / "base.toml") << "title = \"b\"\n";
  const CampaignPlan plan = parse_plan("base = \"base.toml\"\n[parameters]\n\"numerics.cfl\" = [0.4]\n", directory / "plan.toml");
  EXPECT_EQ(plan.base_text, "title = \"b\"\n");
  EXPECT_EQ(plan.base_name, (directory / "base.toml").string());
  EXPECT_TRUE(contains(refusal("base = \"nowhere.toml\"\n[parameters]\n\"numerics.cfl\" = [0.4]\n", ""), "plan.toml:1:8: base:"));
}

TEST(CampaignPlan, ResolvedReadsBackToTheSame) {
  const CampaignPlan plan = plan_of(R"(title = "quote \" and 'this'"
ranks = 5
launcher = ["srun", "-n", "{ranks}"]
threads = 3
retries = 0
order = "plan"
keep = ["frames", "checkpoint"]
[slurm]
partition = "main"
options = ["--constraint=avx512"]
[[grid]]
name = "g"
parameters = { "numerics.cfl" = [0.1, 0.30000000000000004], "material.model" = ["hencky_elastic"] }
)");
  const CampaignPlan again = parse_plan(write_plan(plan), "resolved.toml");
  EXPECT_EQ(again.runs, plan.runs);
  EXPECT_EQ(again.title, plan.title);
  EXPECT_EQ(again.threads, 3);
  EXPECT_EQ(again.ranks, 5);
  EXPECT_EQ(again.launcher, plan.launcher);
  EXPECT_EQ(again.retries, 0);
  EXPECT_FALSE(again.longest_first);
  EXPECT_TRUE(again.keep_frames && again.keep_checkpoint && !again.keep_final);
  EXPECT_EQ(again.slurm, plan.slurm);
  EXPECT_EQ(write_plan(again), write_plan(plan));
}

TEST(CampaignPlan, TellsAllFaultsAtOnceWithTheirPlaces) {
  const std::string reported = refusal(R"(retires = 2
threads = 0
keep = ["movies"]
order = "random"
ranks = -1
launcher = ["mpirun"]
[set]
"numerics.cell_sise_m" = 0.5
froude_number = 3
[[when]]
set = { "output.duration_s" = 3 }
[parameters]
"numerics.cfl" = []
"numerics.cfl, numerics.slope_deg" = [[0.4, 0.0], [0.3]]
"numerics.gravity_m_s2" = [9.81, 9.81]
"numerics.slope_deg" = [1.0]
[[run]]
name = "../up"
[[run]]
)");
  for (const char* part :
       {"plan.toml:1:1: unknown key retires; did you mean retries?", "plan.toml:2:11: threads = 0; give an integer in [1, 1024]",
        "plan.toml:3:8: keep: there is no \"movies\"", "plan.toml:4:9: order = \"random\"",
        "plan.toml:5:9: ranks = -1; give an integer in [1, 100000]", "plan.toml:6:12: launcher: no word says how many ranks it starts",
        "plan.toml:8:1: set: unknown key numerics.cell_sise_m; did you mean \"numerics.cell_size_m\"?",
        "did you mean \"conveyor.froude_number\"?", "[[when]] 1 has no match", "numerics.cfl = [] is empty; give a list of values",
        "numerics.slope_deg is given twice", "[0.3] does not give the 2 keys a value each", "9.81 is given twice",
        "name = \"../up\" names no folder", "[[run]] 2 is empty"}) {
    EXPECT_TRUE(contains(reported, part)) << part << "\n in \n" << reported;
  }
  EXPECT_TRUE(contains(refusal("", ""), "base is missing"));
  EXPECT_TRUE(contains(refusal(""), "the plan has no runs"));
  EXPECT_TRUE(contains(refusal("format_version = 2"), "format_version = 2"));
  EXPECT_TRUE(contains(refusal("= 3"), "plan.toml:1:1: not valid TOML"));
  EXPECT_TRUE(contains(refusal("[parameters]\n"), "[parameters] is empty"));
  EXPECT_TRUE(contains(refusal("[[grid]]\nparameters = {}\n"), "[[grid]] 1 has no parameters"));
  EXPECT_TRUE(contains(refusal("parameters = { \"numerics.cfl\" = \"few\" }\n[lists.few]\n"), "[lists.few] is empty"));
  const CampaignPlan tables = plan_of("[parameters]\n\"numerics.slope_deg\" = [1]\n[[parameters.\"numerics.cfl\"]]\nx = 1\n");
  EXPECT_EQ(tables.runs.at(0).settings.at(1).value, "{ x = 1 }");  // a value on one line, which the case refuses
}

TEST(CampaignPlan, TellsTheErrorsOfItsCasesTogetherWithItsOwn) {
  const std::string reported = refusal(R"(retires = 2
[set]
"numerics.transfer" = "aflop"
"numerics.cel_size_m" = 0.5
[parameters]
"output.duration_s" = [1.0, -1.0]
"numerics.nothing_like_it, numerics.slope_deg" = [[0.4, 0.0], [0.3, "steep"]]
)");
  for (const char* part : {"plan.toml:1:1: unknown key retires", "plan.toml:4:1: set: unknown key numerics.cel_size_m; did you mean",
                           "unknown key numerics.nothing_like_it", "transfer = \"aflop\" is not known (did you mean \"aflip\"?)",
                           "duration_s = -1.0 is out of range", "slope_deg = \"steep\" is a string"}) {
    EXPECT_TRUE(contains(reported, part)) << part << "\n in \n" << reported;
  }
  EXPECT_FALSE(contains(reported, "cell_size_m is missing")) << "that of the misspelt key counts\n" << reported;
  EXPECT_EQ(reported.find("nothing_like_it"), reported.rfind("nothing_like_it")) << "told once\n" << reported;
}

/// A plan in a folder of its own, with the files that it includes.
class PlanFiles : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) { std::ofstream(directory_ / name) << text; }
  CampaignPlan plan(const std::string& text) { return parse_plan(text, directory_ / "plan.toml"); }
  std::string message(const std::string& text) {
    try {
      (void)plan(text);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (directory_ / name).string(); }

 private:
  testing::TemporaryDirectory directory_;
};

TEST(CampaignPlan, AnAxisTakesItsValuesFromAListByName) {
  const CampaignPlan plan = plan_of(R"(lists.speeds = [1, 3]
lists.snows = [[0.4, 0.0], [0.8, 0.3]]
[[grid]]
parameters = { "conveyor.froude_number" = "speeds", "material.critical_state_slope, material.cohesion_beta" = "snows" }
[[grid]]
parameters = { "material.model" = ["speeds"], "material.critical_state_slope, material.cohesion_beta" = "snows" }
)");
  EXPECT_EQ(names_of(plan), (std::vector<std::string>{"fr1_m0.4_beta0", "fr1_m0.8_beta0.3", "fr3_m0.4_beta0", "fr3_m0.8_beta0.3",
                                                      "speeds_m0.4_beta0", "speeds_m0.8_beta0.3"}));
  EXPECT_EQ(values_of(plan.runs[3]),
            (std::map<std::string, std::string>{
                {"conveyor.froude_number", "3"}, {"material.critical_state_slope", "0.8"}, {"material.cohesion_beta", "0.3"}}));
}

TEST(CampaignPlan, AListOfGroupsNamesRunsAfterThem) {
  const CampaignPlan plan = plan_of(R"([parameters]
shape = "shapes"
"conveyor.froude_number" = [3]
[lists.shapes]
wedge = { "obstacle.shape" = "wedge", "obstacle.depth_m" = 1.5 }
as_in_the_base = {}
)");
  EXPECT_EQ(names_of(plan), (std::vector<std::string>{"wedge_fr3", "as_in_the_base_fr3"}));  // in the order of the file
  EXPECT_EQ(plan.runs[0].settings,
            (std::vector<Setting>{{"obstacle.shape", "\"wedge\""}, {"obstacle.depth_m", "1.5"}, {"conveyor.froude_number", "3"}}));
  EXPECT_EQ(plan.runs[1].settings, (std::vector<Setting>{{"conveyor.froude_number", "3"}}));
}

TEST(CampaignPlan, ARuleMatchesKeysTogether) {
  const CampaignPlan plan = plan_of(R"(lists.long = [[1, 0.3], [3, 0]]
[[when]]
match = { "conveyor.froude_number, material.cohesion_beta" = "long" }
set = { "output.duration_s" = 30 }
[parameters]
"conveyor.froude_number" = [1, 3]
"material.cohesion_beta" = [0.0, 0.3]
)");
  std::vector<std::string> matched;
  for (const PlannedRun& run : plan.runs) {
    if (values_of(run).contains("output.duration_s")) matched.push_back(run.name);
  }
  EXPECT_EQ(matched, (std::vector<std::string>{"fr1_beta0.3", "fr3_beta0"}));
}

TEST(CampaignPlan, FaultsOfListsAreToldWithARemedy) {
  const std::string reported = refusal(R"([lists]
speeds = [1, 3]
pairs = [[1, 2], [3]]
number = 3
none = []
twice = [1, 1]
[lists.groups]
a = { "numerics.clf" = 0.4 }
b = 3
"a b" = {}
[[grid]]
parameters = { "conveyor.froude_number" = "speed" }
[[grid]]
parameters = { "numerics.transfer" = "apic" }
[[grid]]
parameters = { "conveyor.froude_number" = "none", "material.cohesion_beta" = "twice", "numerics.cfl, numerics.slope_deg" = "pairs" }
[[grid]]
parameters = { "numerics.cfl" = [0.4], g = "groups", "numerics.cfl, numerics.slope_deg" = [[0.2, 0]] }
)");
  for (const char* part :
       {"plan.toml:12:16: [[grid]] 1 parameters: conveyor.froude_number = \"speed\": [lists] has no such list; did you mean \"speeds\"?",
        "plan.toml:14:16: [[grid]] 2 parameters: numerics.transfer = \"apic\": [lists] has no such list; give a list of values, or the",
        "plan.toml:4:1: [lists] number = 3 is an integer; give a list of values, or groups of settings",
        "plan.toml:16:16: [[grid]] 3 parameters: conveyor.froude_number = \"none\" is empty",
        "plan.toml:6:13: [[grid]] 3 parameters: material.cohesion_beta: 1 is given twice",
        "plan.toml:3:18: [[grid]] 3 parameters: numerics.cfl, numerics.slope_deg: [3] does not give the 2 keys a value each",
        "plan.toml:8:7: [lists.groups] a: unknown key numerics.clf; did you mean \"numerics.cfl\"?",
        "plan.toml:9:5: [lists.groups] b = 3 is an integer; give a table",
        "plan.toml:10:1: [lists.groups] group \"a b\": its name is part of names of runs",
        "[[grid]] 4 parameters: numerics.cfl is given twice; give it once"}) {
    EXPECT_TRUE(contains(reported, part)) << part << "\n in \n" << reported;
  }
  EXPECT_TRUE(contains(refusal("lists = 3"), "plan.toml:1:9: lists = 3 is an integer; give a table"));
}

TEST_F(PlanFiles, WhatThePlanGivesWinsOverWhatItIncludes) {
  write("base.toml", "title = \"b\"\n");
  write("table.csv", "name,numerics.cfl\nfrom_the_table,0.1\n");
  write("shared.toml", R"(base = "base.toml"
title = "shared"
order = "plan"
threads = 2
keep = ["final"]
table = "table.csv"
lists.speeds = [1]
lists.slopes = [0, 10]
slurm = { partition = "p", account = "a" }
labels = { "numerics.slope_deg" = "s" }
[set]
"output.duration_s" = 1
"numerics.cell_size_m" = 0.5
[[when]]
match = { "conveyor.froude_number" = 3 }
set = { "output.duration_s" = 2, "output.series_per_second" = 20 }
[[grid]]
name = "shared"
parameters = { "conveyor.froude_number" = "speeds" }
[parameters]
"conveyor.froude_number" = [7]
"numerics.slope_deg" = "slopes"
)");
  const CampaignPlan all = plan(R"(include = ["shared.toml"]
title = "own"
keep = ["frames"]
lists.speeds = [3, 5]
slurm.account = "b"
set = { "numerics.cell_size_m" = 0.25 }
[[when]]
match = { "conveyor.froude_number" = 3 }
set = { "output.duration_s" = 3 }
[[grid]]
name = "own"
parameters = { "conveyor.froude_number" = "speeds" }
[parameters]
"conveyor.froude_number" = [1]
)");
  EXPECT_EQ(names_of(all),
            (std::vector<std::string>{"fr1_s0", "fr1_s10", "own_fr3", "own_fr5", "shared_fr3", "shared_fr5", "from_the_table"}));
  EXPECT_EQ(values_of(all.runs[2]), (std::map<std::string, std::string>{{"conveyor.froude_number", "3"},
                                                                        {"numerics.cell_size_m", "0.25"},
                                                                        {"output.duration_s", "3"},
                                                                        {"output.series_per_second", "20"}}));
  EXPECT_EQ(values_of(all.runs[3]).at("output.duration_s"), "1");
  EXPECT_EQ(all.title, "own");
  EXPECT_EQ(all.base_text, "title = \"b\"\n");
  EXPECT_EQ(all.threads, 2);
  EXPECT_FALSE(all.longest_first);
  EXPECT_TRUE(all.keep_frames && !all.keep_final);
  EXPECT_EQ(all.slurm.partition + all.slurm.account, "pb");
}

TEST_F(PlanFiles, AreReadOnceEachAndNameFilesRelativeToThemselves) {
  std::filesystem::create_directory(path("inner"));
  write("base.toml", "title = \"b\"\n");
  write("inner/common.toml", "base = \"../base.toml\"\n[[grid]]\nparameters = { \"numerics.cfl\" = [0.4] }\n");
  write("inner/a.toml", "include = [\"common.toml\"]\n[[run]]\nname = \"a\"\n");
  write("b.toml", "include = [\"inner/common.toml\"]\nset = { \"output.duration_s\" = 2 }\n[[run]]\nname = \"b\"\n");
  const CampaignPlan both = plan("include = [\"inner/a.toml\", \"b.toml\"]\n");
  EXPECT_EQ(names_of(both), (std::vector<std::string>{"cfl0.4", "a", "b"}));
  EXPECT_EQ(values_of(both.runs[1]).at("output.duration_s"), "2");
  EXPECT_EQ(names_of(parse_plan(write_plan(both), path("resolved.toml"))), names_of(both));
}

TEST_F(PlanFiles, FaultsOfIncludesAreToldWithTheirFile) {
  const std::string run = std::string(inline_base) + "[[run]]\nname = \"r\"\n";
  EXPECT_TRUE(contains(message("include = [\"no.toml\"]\n" + run), path("plan.toml") + ":1:11: include: \"no.toml\" is not a file"));
  EXPECT_TRUE(contains(message("include = \"no.toml\"\n" + run), ":1:11: include = \"no.toml\"; give a list of strings"));
  write("a.toml", "include = [\"b.toml\"]\n");
  write("b.toml", "\ninclude = [\"a.toml\"]\n");
  EXPECT_TRUE(contains(message("include = [\"a.toml\"]\n" + run), path("b.toml") + ":2:11: include: \"a.toml\" leads back to itself"));
  write("plan.toml", "");
  EXPECT_TRUE(contains(message("include = [\"plan.toml\"]\n" + run), ":1:11: include: \"plan.toml\" leads back to itself"));
  write("syntax.toml", "set = {\n");
  EXPECT_TRUE(contains(message("include = [\"syntax.toml\"]\n" + run), path("syntax.toml") + ":1:"));
  write("twice.toml", "threads = 1\nthreads = 2\n");  // a key twice in one file
  EXPECT_TRUE(contains(message("include = [\"twice.toml\"]\n" + run), path("twice.toml") + ":2:11: not valid TOML"));
  write("faults.toml", "threads = 0\n\n\nset = { \"numerics.clf\" = 1 }\n[parameters]\n\"numerics.cfl\" = [0.4]\n");
  const std::string mixed =
      message("include = [\"faults.toml\"]\nretires = 2\n[parameters]\n\"numerics.cfl, numerics.slope_deg\" = [[0.2, 0]]\n" + run);
  const auto own = mixed.find(path("plan.toml") + ":2:1: unknown key retires"), twice = mixed.find("numerics.cfl is given twice");
  const auto first = mixed.find(path("faults.toml") + ":1:11: threads = 0"),
             second = mixed.find(path("faults.toml") + ":4:9: set: unknown key numerics.clf");
  EXPECT_TRUE(own < twice && twice < first && first < second && second != std::string::npos) << mixed;
  for (int i = 0; i < 40; ++i) write("f" + std::to_string(i) + ".toml", "include = [\"f" + std::to_string(i + 1) + ".toml\"]\n");
  EXPECT_TRUE(contains(message("include = [\"f0.toml\"]\n" + run),
                       path("f30.toml") + ":1:11: include: \"f31.toml\" is one too many: a plan has at most 32 files"));
}

TEST(CampaignPlan, EveryNameOfARunIsThatOfAFolderOfItsOwn) {
  const testing::TemporaryDirectory directory;
  for (const std::string& name : {std::string("."), std::string(".."), std::string(".x"), std::string("--help"), std::string("-1"),
                                  std::string("a/b"), std::string("a b"), std::string(201, 'x'), std::string("\xff")}) {
    SCOPED_TRACE(name);
    EXPECT_TRUE(contains(name_problem(name), "names no folder"));
    std::ofstream(directory / "rows.csv") << "name,numerics.cfl\n" << name << ",0.4\n";
    try {
      (void)parse_plan(std::string("table = \"rows.csv\"\n") + inline_base, directory / "plan.toml");
      FAIL() << "accepted";
    } catch (const ConfigError& error) {
      EXPECT_TRUE(contains(error.what(), name == "\xff" ? "rows.csv:2: a character is not UTF-8" : "row 1: name = ")) << error.what();
    }
    if (name == "\xff") continue;  // no TOML
    for (const std::string block : {"[[run]]\n", "[[grid]]\nparameters = { \"numerics.cfl\" = [0.4] }\n"})
      EXPECT_TRUE(contains(refusal(block + "name = \"" + name + "\"\n"), "names no folder")) << block;
  }
  // names that are made from values
  const std::string negative = "[parameters]\n\"numerics.slope_deg\" = [-3]\n";
  EXPECT_TRUE(contains(refusal(negative + "[labels]\n\"numerics.slope_deg\" = \"\"\n"), "\"-3\" names no folder"));
  EXPECT_EQ(names_of(plan_of(negative)), (std::vector<std::string>{"slope-3"}));
  EXPECT_TRUE(contains(refusal("[[run]]\nset = { \"title\" = \"" + std::string(300, 'x') + "\" }\n"), "names no folder"));
  for (const std::string& name : {std::string("a"), std::string("dx0.25_xi+1"), std::string("_"), std::string(200, 'x')})
    EXPECT_EQ(name_problem(name), "") << name;
}

TEST(CampaignPlan, ACellOfATableIsAValueWhateverItHolds) {
  const testing::TemporaryDirectory directory;
  std::string deep = "{ a";
  for (int i = 0; i < 300'000; ++i) deep += ".a";
  std::ofstream(directory / "rows.csv") << "name,title\na,\"" << deep << " = 1 }\"\nb,1 # one\nc,\"'x # y'\"\n";
  const CampaignPlan plan = parse_plan(std::string("table = \"rows.csv\"\n") + inline_base, directory / "plan.toml");
  EXPECT_EQ(plan.runs[0].settings[0].value.front(), '"');  // text
  EXPECT_EQ(plan.runs[1].settings[0].value, "1");
  EXPECT_EQ(plan.runs[2].settings[0].value, "\"x # y\"");
  EXPECT_EQ(names_of(parse_plan(write_plan(plan), "plan.toml")), names_of(plan));
}

TEST(CampaignPlan, IsBoundedInRunsKeysAndRules) {
  std::string values = "[0.1";
  for (int i = 1; i < 1000; ++i) values += ", " + std::to_string(0.1 + 1e-6 * i);
  EXPECT_TRUE(contains(refusal("[parameters]\n\"numerics.cfl\" = " + values + "]\n\"numerics.slope_deg\" = " + values + "]\n"),
                       "more than 100000 runs"));
  const auto repeated = [](int times, const auto& text_of) {
    std::string text;
    for (int i = 0; i < times; ++i) text += text_of(i);
    return text;
  };
  EXPECT_TRUE(contains(refusal("[set]\n" + repeated(200'000, [](int i) { return "k" + std::to_string(i) + " = 1\n"; })),
                       "at least 800 more errors"));
  EXPECT_TRUE(
      contains(refusal("[set]\n" + repeated(2000, [](int i) { return "\"body[" + std::to_string(i) + "].spin\" = 1\n"; })), "errors"));
  EXPECT_TRUE(contains(refusal(repeated(1001, [](int) { return "[[when]]\n"; })), "[[when]] is given 1001 times; at most 1000"));
}

TEST(PlanFile, NamesFilesOfItsBaseFromAnyFolder) {
  CampaignPlan plan = parse_plan(
      "[base.conveyor]\ninflow_csv = \"surge.csv\"\n[base.terrain]\nfile = \"/hill.asc\"\n[[run]]\nname = \"a\"\n"
      "[[run]]\nset = { \"conveyor.inflow_csv\" = \"thaw.csv\" }\n",
      "/sites/plan.toml");
  const std::string text = write_plan(plan);
  EXPECT_NE(text.find("\"conveyor.inflow_csv\" = \"/sites/thaw.csv\""), std::string::npos) << text;
  EXPECT_NE(text.find("/sites/surge.csv"), std::string::npos) << text;
  EXPECT_NE(text.find("/hill.asc"), std::string::npos) << text;
  EXPECT_EQ(write_plan(parse_plan(text, "/other/plan.toml")), text);
}

}  // namespace
}  // namespace mpm
