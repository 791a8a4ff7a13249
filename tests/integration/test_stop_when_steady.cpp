/// Runs that end when their means are known: `[output] stop_when_steady`.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;

constexpr double flow_speed = 6.0, full_duration = 12.0;

/// Coarse and fast: 42 flow heights take 7 s, and the loosest limit is met long before the end.
Case avalanche(double limit) {
  Case c = testing::small_avalanche(flow_speed);
  c.obstacle->shape = BoxShape{.width = 1.0, .depth = 1.0};
  c.numerics.cell_size = 0.5;
  c.output.duration = full_duration;
  c.output.frames_per_second = 0.0;
  c.output.stop_when_steady = limit;
  return c;
}

class StopWhenSteady : public ::testing::Test {
 protected:
  RunResult run(const Case& c, const std::string& name, bool resume = false, int threads = 1, int stop_after = 0) const {
    RunOptions options;
    options.out = directory / name;
    options.resume = resume;
    options.threads = threads;
    if (stop_after > 0) options.poll = [left = stop_after]() mutable { return --left <= 0 ? Request::stop : Request::none; };
    return run_case(c, options);
  }
  [[nodiscard]] std::string content(const std::string& file) const { return read_file(directory / file); }
  [[nodiscard]] nlohmann::json results(const std::string& name) const { return nlohmann::json::parse(content(name + "/results.json")); }
  void expect_same(const std::string& a, const std::string& b) const {
    for (const char* file : {"/final.h5", "/series.csv", "/profile.csv", "/profiles.h5"})
      EXPECT_EQ(content(a + file), content(b + file)) << file;
    for (const char* name : {"duration_s", "runup_mean_m", "force_mean_n", "stopped_when_steady", "stop_when_steady"})
      EXPECT_EQ(results(a)[name], results(b)[name]) << name;
  }
  testing::TemporaryDirectory directory;
};

TEST_F(StopWhenSteady, EndsBeforeItsDurationAndResumesToTheSameBits) {
  const RunResult whole = run(avalanche(0.2), "whole");
  EXPECT_TRUE(whole.finished);
  EXPECT_GT(whole.time, settled_passage_heights / flow_speed);
  EXPECT_LT(whole.time, full_duration);
  EXPECT_EQ(results("whole")["stopped_when_steady"], true);
  EXPECT_EQ(results("whole")["stop_when_steady"], 0.2);
  EXPECT_EQ(results("whole")["duration_s"], whole.time);
  EXPECT_EQ(results("whole")["steady"], true);
  EXPECT_THAT(content("whole/run.log"), HasSubstr("the means are known to 20 % (output.stop_when_steady)"));

  EXPECT_FALSE(run(avalanche(0.2), "parts", false, 1, 60).finished);
  EXPECT_TRUE(run(avalanche(0.2), "parts", true, 2).finished);
  expect_same("whole", "parts");
  EXPECT_EQ(run(avalanche(0.2), "parts", true).time, whole.time) << "resumed after its end it stays as it is";
  expect_same("whole", "parts");
}

TEST_F(StopWhenSteady, GoesOnWithoutTheKeyAsIfItHadNeverEnded) {
  run(avalanche(0.0), "full");
  EXPECT_EQ(results("full")["stopped_when_steady"], false);
  EXPECT_EQ(results("full")["duration_s"], full_duration);
  ASSERT_LT(run(avalanche(0.2), "extended").time, full_duration);
  EXPECT_TRUE(run(avalanche(0.0), "extended", true).finished);
  expect_same("full", "extended");
}

TEST_F(StopWhenSteady, IsCompleteInACampaignThatAsksForNoMore) {
  const auto run_of = [](double limit) {
    CampaignRun r;
    r.name = "a";
    r.spec = avalanche(limit);
    r.case_hash = case_hash_text(r.spec);
    return r;
  };
  EXPECT_EQ(run_of(0.2).case_hash, run_of(0.0).case_hash) << "it only says how long to run";
  run(avalanche(0.1), "runs/a");
  ASSERT_EQ(results("runs/a")["stopped_when_steady"], true);
  const auto state = [&](double limit) { return status_of(directory.path(), run_of(limit)).state; };
  EXPECT_EQ(state(0.1), RunState::done);
  EXPECT_EQ(state(0.2), RunState::done) << "it has more than that";
  EXPECT_EQ(state(0.05), RunState::to_do);
  EXPECT_EQ(state(0.0), RunState::to_do);
  EXPECT_TRUE(can_go_on(directory / "runs/a", run_of(0.05))) << "from its checkpoint";
  Case shorter = avalanche(0.1);
  shorter.output.duration = 1.0;
  EXPECT_FALSE(finished_results(directory / "runs/a", shorter)) << "it lasted longer than the case";
}

TEST_F(StopWhenSteady, IsRefusedWhereThereIsNoMeanToWaitFor) {
  const auto message = [](const Case& c) -> std::string {
    try {
      (void)parse_case(write_case(c), "case.toml");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(message(avalanche(0.02)), "");
  Case c = avalanche(0.02);
  c.obstacle.reset();
  EXPECT_THAT(message(c), HasSubstr("[output] stop_when_steady = 0.02 has no obstacle to wait for; give [obstacle], or leave the key out"));
  c = avalanche(0.02);
  c.conveyor->inflow = {{.time = 0.0, .velocity = 6.0, .flow_height = 1.0}, {.time = 5.0, .velocity = 3.0, .flow_height = 1.0}};
  EXPECT_THAT(message(c), HasSubstr("needs a steady inflow"));
}

}  // namespace
}  // namespace mpm
