/// `mpm campaign` as a user runs it: whole, killed, stopped, resumed.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "libmpm/base/error.hpp"
#include "libmpm/io/csv.hpp"
#include "support/command_test.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;

using testing::contains;
using testing::content;
using testing::Outcome;

/// Four small avalanches.
const std::string avalanches = std::string("title = \"Small avalanches\"\n") + testing::avalanche_plan +
                               "[parameters]\n\"numerics.cell_size_m\" = [0.25, 0.2]\n\"obstacle.friction\" = [0.0, 0.3]\n";

class CampaignCommand : public testing::CommandTest {
 protected:
  void SetUp() override { std::ofstream(directory_ / "plan.toml") << avalanches; }

  [[nodiscard]] Outcome campaign(const std::string& arguments) const { return mpm("campaign " + arguments); }

  /// Starts a campaign, waits until a run has come some way, sends it a signal, and waits for its end.
  [[nodiscard]] Outcome interrupted(const std::string& folder, const std::string& signal) const {
    return shell("'" MPM_APP "' campaign run plan.toml --jobs 2 --out " + folder +
                 " & p=$!\n"
                 "until [ \"$(cat " +
                 folder +
                 "/runs/*/series.csv 2>/dev/null | wc -l)\" -gt 12 ] || ! kill -0 $p 2>/dev/null; do sleep 0.02; done\n"
                 "kill -" +
                 signal + " $p; wait $p");
  }

  /// Every run was finished once, and no attempt at it began before the one before had ended or was cut off.
  void expect_nothing_done_twice(const fs::path& out) const {
    for (const auto& entry : fs::directory_iterator(out / "runs")) {
      const auto attempts = nlohmann::json::parse(content(entry.path() / "attempts.json"))["attempts"];
      const auto done = std::count_if(attempts.begin(), attempts.end(), [](const auto& a) { return a["outcome"] == "done"; });
      EXPECT_LE(done, 1) << entry.path();
      // the log is begun anew by a start and continued by a resumption: one start, and one end
      const std::string log = content(entry.path() / "run.log");
      std::size_t ends = 0;
      for (std::size_t at = log.find(" done: "); at != std::string::npos; at = log.find(" done: ", at + 1)) ++ends;
      EXPECT_EQ(ends, 1u) << log;
    }
  }
};

TEST_F(CampaignCommand, KilledOrStoppedAndResumedLeavesTheSameTableAndNothingIsDoneTwice) {
  const Outcome whole = campaign("run plan.toml --out whole --jobs 2");
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_TRUE(contains(whole.out, "4 runs in whole: 4 done, 0 running, 0 failed, 0 to do")) << whole.out;
  const std::string table = content(directory_ / "whole/results.csv");
  EXPECT_EQ(Table::read(directory_ / "whole/results.csv").text("status"), (std::vector<std::string>(4, "done")));

  for (const std::string signal : {"KILL", "TERM", "INT"}) {
    SCOPED_TRACE(signal);
    Outcome cut{0, "", ""};
    for (int attempt = 0; attempt < 5 && cut.code == 0; ++attempt) {  // on a busy machine the campaign may end before the signal
      fs::remove_all(directory_ / signal);
      cut = interrupted(signal, signal);
    }
    EXPECT_NE(cut.code, 0) << cut.err;
    const Outcome status = campaign("status plan.toml --list --out " + signal);
    EXPECT_EQ(status.code, 0) << status.err;
    EXPECT_FALSE(contains(status.out, "4 done")) << status.out;
    // at once: what was killed may have left children that still write their checkpoints
    const Outcome rest = campaign("run plan.toml --jobs 2 --out " + signal);
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(content(directory_ / signal / "results.csv"), table);
    expect_nothing_done_twice(directory_ / signal);
    bool resumed = false;  // not all from the beginning
    for (const auto& entry : fs::directory_iterator(directory_ / signal / "runs"))
      resumed = resumed || contains(content(entry.path() / "run.log"), "resumed at t = ");
    EXPECT_TRUE(resumed);
  }

  // once more: nothing is run
  const Outcome again = campaign("run plan.toml --out whole --jobs 2");
  EXPECT_EQ(again.code, 0);
  EXPECT_FALSE(contains(again.err, "started")) << again.err;
  EXPECT_EQ(content(directory_ / "whole/results.csv"), table);
}

TEST_F(CampaignCommand, ASecondOneInTheSameFolderIsRefused) {
  std::ofstream(directory_ / "plan.toml")  // ends by the signal only
      << testing::falling_block_plan << "[[run]]\nname = \"long\"\nset = { \"numerics.gravity_m_s2\" = 0, \"output.duration_s\" = 1e4 }\n";
  const Outcome o = shell("'" MPM_APP
                          "' campaign run plan.toml --out x 2>/dev/null >/dev/null & p=$!\n"
                          "until [ -e x/plan.toml ] || ! kill -0 $p; do sleep 0.02; done\n"
                          "'" MPM_APP "' campaign run plan.toml --out x; code=$?; kill -TERM $p; wait $p; exit $code");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::io));
  EXPECT_TRUE(contains(o.err, "another process is running in this directory")) << o.err;
}

TEST_F(CampaignCommand, StatusOfAPlanThatWasNeverRunShowsItsCostAndWritesNothing) {
  const Outcome o = campaign("status plan.toml --list --out nowhere");
  EXPECT_EQ(o.code, 0) << o.err;
  for (const char* part : {"4 runs", "0 done", "4 to do", "particle-steps in all", "(assumed)", "dx0.25_mu0 ", "dx0.2_mu0.3 "})
    EXPECT_TRUE(contains(o.out, part)) << part << "\n" << o.out;
  EXPECT_FALSE(fs::exists(directory_ / "nowhere"));
}

TEST_F(CampaignCommand, FailedRunsAreTableRowsWithACauseAndExitCode1) {
  // sound travels at millimetres a second and the block at 900 m/s: the time step collapses
  std::ofstream(directory_ / "blocks.toml") << testing::falling_block_plan << R"([base.numerics]
cell_size_m = 0.25
[[run]]
name = "calm"
[[run]]
name = "wild"
set = { "body[0].velocity_m_s" = [900, 0, 0], "material.young_modulus_pa" = 1, "material.density_kg_m3" = 1e5 }
)";
  const Outcome o = campaign("run blocks.toml --out b");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::failed)) << o.err;
  const Table table = Table::read(directory_ / "b/results.csv");
  EXPECT_EQ(table.text("status"), (std::vector<std::string>{"done", "failed"}));
  EXPECT_TRUE(contains(table.text("cause")[1], "exit code 3: ")) << table.text("cause")[1];
  EXPECT_EQ(Table::read(directory_ / "b/runs.csv").text("attempts"), (std::vector<std::string>{"1", "1"}));  // not tried again
  EXPECT_TRUE(contains(campaign("status blocks.toml --out b").out, "failed  wild")) << o.out;
}

TEST_F(CampaignCommand, StatusBringsTheTablesUpToDateButNotThoseOfAnotherPlan) {
  const std::string base =
      "base = { material = { model = \"hencky_elastic\" }, body = [{ min_m = [0, 0, 0], max_m = [1, 1, 1] }], "
      "domain = { min_m = [-5, -5, -5], max_m = [5, 5, 5] }, output = { duration_s = 0.02 } }\n";
  std::ofstream(directory_ / "a.toml") << base << "[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.25]\n";
  ASSERT_EQ(campaign("run a.toml --out o").code, 0);
  const std::string table = content(directory_ / "o/results.csv");
  fs::remove(directory_ / "o/results.csv");
  EXPECT_EQ(campaign("status a.toml --out o").code, 0);
  EXPECT_EQ(content(directory_ / "o/results.csv"), table);
  for (const char* changed : {"[parameters]\n\"numerics.cell_size_m\" = [0.5]\n",
                              "[set]\n\"numerics.cfl\" = 0.3\n[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.25]\n"}) {
    std::ofstream(directory_ / "b.toml") << base << changed;
    const Outcome o = campaign("status b.toml --out o");
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_TRUE(contains(o.err, "1 run in the folder but not in the plan") || contains(o.err, "2 runs changed since the last campaign"))
        << o.err;
    EXPECT_EQ(content(directory_ / "o/results.csv"), table);
  }
}

TEST_F(CampaignCommand, RefusesWithExitCode2) {
  std::ofstream(directory_ / "bad.toml") << "base = \"none.toml\"\nthreds = 2\n";
  for (const auto& [arguments, words] :
       std::initializer_list<std::pair<std::string, std::string>>{{"run bad.toml", "did you mean threads?"},
                                                                  {"status bad.toml", "bad.toml:1:8: base:"},
                                                                  {"run", "plan"},
                                                                  {"run plan.toml --executor cloud", "--executor"},
                                                                  {"submit plan.toml --executor local", "--executor"},
                                                                  {"run plan.toml --jobs 0", "--jobs"},
                                                                  {"", "subcommand"}}) {
    SCOPED_TRACE(arguments);
    const Outcome o = campaign(arguments);
    EXPECT_EQ(o.code, static_cast<int>(ExitCode::usage)) << o.err;
    EXPECT_TRUE(contains(o.err, words)) << o.err;
  }
  EXPECT_EQ(campaign("run nowhere.toml").code, static_cast<int>(ExitCode::io));
}

}  // namespace
}  // namespace mpm
