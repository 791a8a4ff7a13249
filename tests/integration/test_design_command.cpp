/// `mpm design` as a user runs it.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/site.hpp"
#include "support/command_test.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;

using testing::contains;
using testing::content;
using testing::Outcome;

/// A slow shallow flow on a mast, two coarse grids: some seconds of work.
constexpr const char* small_site = R"(title = "Small"
[flow]
depth_m = 1.0
velocity_m_s = 3.0
[[snow]]
name = "only"
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 0.1
[mast]
width_m = 1.0
[[mode]]
frequency_hz = 2.0
[plan]
finest_cells = 5
grids = 2
duration_s = 1.2
)";

class DesignCommand : public testing::CommandTest {
 protected:
  void write(const std::string& text) const { std::ofstream(directory_ / "site.toml") << text; }
  [[nodiscard]] Outcome design(const std::string& arguments) const { return mpm("design site.toml " + arguments); }
};

TEST_F(DesignCommand, RunsTheEnsembleAndWritesThePageWithItsTables) {
  write(small_site);
  const Outcome first = design("--out loads");
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_TRUE(contains(first.out, "force downstream")) << first.out;
  EXPECT_TRUE(contains(first.err, "only_w5: done")) << first.err;
  const fs::path out = directory_ / "loads";
  for (const char* file : {"design.html", "design.json", "design.csv", "pressure_over_height.csv", "loads_over_time.csv",
                           "shock_spectrum.csv", "site.toml", "design_plan.json", "plan.toml", "results.csv", "runs/only_w3/results.json"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  EXPECT_EQ(read_site(out / "site.toml"), parse_site(small_site, "small"));
  const auto json = nlohmann::json::parse(content(out / "design.json"));
  EXPECT_GT(json["design_force_n"].get<double>(), 0.0);

  const Outcome again = design("--out loads");  // everything is done: only the page
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_FALSE(contains(again.err, "started")) << again.err;

  fs::remove(out / "design.html");
  EXPECT_EQ(design("--out loads --page").code, 0);
  EXPECT_TRUE(fs::exists(out / "design.html"));

  // Another site, a changed result, and another process in the folder: no page, and everything stays as it was.
  const auto kept = [&] { return content(out / "design.html") + content(out / "design_plan.json") + content(out / "site.toml"); };
  const std::string before = kept();
  std::string faster = small_site;
  write(faster.replace(faster.find("3.0"), 3, "3.5"));
  const Outcome other = design("--out loads --page");
  EXPECT_EQ(other.code, static_cast<int>(ExitCode::io));
  EXPECT_TRUE(contains(other.err, "2 runs are not finished for this site")) << other.err;
  EXPECT_EQ(kept(), before);
  write(small_site);
  const Outcome busy = shell("flock loads/.lock '" MPM_APP "' design site.toml --out loads");
  EXPECT_EQ(busy.code, static_cast<int>(ExitCode::io));
  EXPECT_TRUE(contains(busy.err, "another process is running")) << busy.err;
  EXPECT_EQ(kept(), before);
  std::string results = content(out / "runs/only_w5/results.json");
  std::ofstream(out / "runs/only_w5/results.json") << results.insert(results.find("\"force_peak_n\": ") + 16, "9");
  EXPECT_EQ(design("--out loads --page").code, static_cast<int>(ExitCode::io));
  EXPECT_EQ(kept(), before);
  const Outcome repaired = design("--out loads");
  EXPECT_EQ(repaired.code, 0) << repaired.err;
  EXPECT_TRUE(contains(repaired.err, "1 run with damaged results; to be run again: only_w5")) << repaired.err;
}

TEST_F(DesignCommand, PrintsThePlanAndWritesNothing) {
  write(small_site);
  const Outcome o = design("--quick --plan");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(contains(o.out, "runs   2 of ")) << o.out;
  EXPECT_TRUE(contains(o.out, "warning: ")) << o.out;  // xi = 0.1 is below the 0.15 that the equations were fitted to
  EXPECT_FALSE(contains(o.out, "{")) << "for people";
  const Outcome json = design("--quick --plan --json");
  EXPECT_EQ(nlohmann::json::parse(json.out)["level"], "quick");
  EXPECT_FALSE(fs::exists(directory_ / "out"));
}

TEST_F(DesignCommand, RefusesAWrongSiteWithExitCode2AndLeavesNoTrace) {
  write("[flow]\ndepth_m = 2\nvelocity = 14\nsnow_class = \"loose\"\n[mast]\nwidth_m = 0.8\n");
  const Outcome o = design("");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::usage));
  EXPECT_TRUE(contains(o.err, "site.toml:3:1")) << o.err;
  EXPECT_TRUE(contains(o.err, "velocity_m_s")) << o.err;
  write("[flow]\nnothing_like_it = 14\n");
  EXPECT_TRUE(contains(design("").err, "site.toml:2:1: [flow] unknown key nothing_like_it; see `mpm schema --site`"));
  EXPECT_TRUE(contains(o.err, "mpm schema --site")) << o.err;
  EXPECT_FALSE(fs::exists(directory_ / "out"));
}

TEST_F(DesignCommand, RefusesAWrongOverrideWithExitCode2) {
  write(small_site);
  const Outcome o = design("--set numerics.clf=0.3");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::usage));
  EXPECT_TRUE(contains(o.err, "cfl")) << o.err;
}

TEST_F(DesignCommand, RefusesAnOverrideOfWhatTheSiteDecides) {
  write(small_site);
  for (const auto& [key, own] :
       {std::pair{"obstacle.friction=1", "mast.friction"}, std::pair{"obstacle.rotation_deg=45", "[mast]"},
        std::pair{"material.critical_state_slope=1", "[[snow]]"}, std::pair{"conveyor.flow_height_m=2", "flow.depth_m"},
        std::pair{"numerics.gravity_m_s2=20", "flow.slope_deg"}, std::pair{"numerics.cell_size_m=0.25", "plan.finest_cells"},
        std::pair{"output.duration_s=3", "plan.duration_s"}}) {
    const Outcome o = design(std::string("--quick --plan --set ") + key);
    EXPECT_EQ(o.code, static_cast<int>(ExitCode::usage)) << key;
    EXPECT_TRUE(contains(o.err, std::string("give ") + own + " there")) << o.err;
  }
  const Outcome allowed = design("--quick --plan --json --set conveyor.lattice=aligned");
  EXPECT_EQ(nlohmann::json::parse(allowed.out)["overrides"], std::vector<std::string>{"conveyor.lattice=aligned"});
}

TEST_F(DesignCommand, NamesRunsThatAreMissingForThePage) {
  write(small_site);
  const Outcome o = design("--out loads --page");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::io));
  EXPECT_TRUE(contains(o.err, "2 runs are not finished")) << o.err;
}

}  // namespace
}  // namespace mpm
