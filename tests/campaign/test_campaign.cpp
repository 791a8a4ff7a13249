#include "libmpm/campaign/campaign.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>
#include <set>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/execution.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/run.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "support/temporary_directory.hpp"
#include "support/text.hpp"

namespace mpm {
namespace {

using testing::contains;

namespace fs = std::filesystem;

/// Blocks that fall for 0.02 s: 64 and 512 particles, six to twelve steps.
const std::string blocks = std::string("title = \"Blocks\"\n") + testing::falling_block_plan;

Campaign campaign_of(const std::string& more) { return make_campaign(parse_plan(blocks + more, "plan.toml")); }

const char* const two_sizes = "[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.25]\n";

/// Runs one of a campaign as `mpm run` would.
void compute(const fs::path& out, const CampaignRun& run) {
  prepare_run(out, run);
  RunOptions options;
  options.out = run_directory(out, run);
  options.threads = 1;
  (void)run_case(run.spec, options);
}

class CampaignFolder : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path out() const { return directory_ / "out"; }

  /// A program that does what a shell script says, in place of mpm; $3 is the folder of the run... `run CASE --out DIR --threads N
  /// --resume`.
  [[nodiscard]] fs::path program(const std::string& script) const {
    fs::path path = directory_ / "program.sh";
    std::ofstream(path) << "#!/bin/sh\n" << script;
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }

  ExecutionReport run_with(const Campaign& campaign, const std::string& script, bool retry_failed = false) {
    ExecutionOptions options{out(), program(script), 2, retry_failed, {}, {}, {}};
    options.say = [this](const std::string& line) { said_ += line + "\n"; };
    prepare(out(), campaign);
    std::vector<std::size_t> all(campaign.runs.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    return execute(campaign, all, options);
  }

  testing::TemporaryDirectory directory_;
  std::string said_;
};

TEST(Campaign, KeepsEachCaseOnceAndTurnsFramesOff) {
  const Campaign c = campaign_of(std::string(two_sizes) + "[[run]]\nname = \"again\"\nset = { \"numerics.cell_size_m\" = 0.50 }\n" +
                                 "[[run]]\nname = \"longer\"\nset = { \"numerics.cell_size_m\" = 0.5, \"output.duration_s\" = 0.03 }\n");
  ASSERT_EQ(c.runs.size(), 3u);
  EXPECT_EQ(c.duplicates, 1u);
  EXPECT_EQ(c.runs[0].name, "dx0.5");
  EXPECT_EQ(c.runs[2].name, "longer");
  EXPECT_EQ(c.runs[0].case_hash, c.runs[2].case_hash);  // a longer run of the same case
  EXPECT_EQ(c.runs[0].spec.title, "Blocks: dx0.5");
  EXPECT_EQ(c.runs[0].spec.output.frames_per_second, 0.0);
  EXPECT_GT(c.runs[1].cost.particle_steps, c.runs[0].cost.particle_steps);
  const Campaign kept = make_campaign(parse_plan("keep = [\"frames\"]\n" + blocks + two_sizes, "plan.toml"));
  EXPECT_EQ(kept.runs[0].spec.output.frames_per_second, OutputSpec{}.frames_per_second);
}

TEST(Campaign, TellsRunsApartThatEndOrAreMeasuredByOtherRules) {
  const Campaign c = make_campaign(
      parse_plan(std::string(testing::avalanche_plan) +
                     "[parameters]\n\"output.stop_when_steady\" = [0.05, 0.01]\n\"measurement.steady_by\" = [\"runup_p99\", \"runup\"]\n",
                 "plan.toml"));
  ASSERT_EQ(c.runs.size(), 4u);
  EXPECT_EQ(c.duplicates, 0u);
  EXPECT_EQ(c.runs[0].case_hash, c.runs[3].case_hash);
  Results done;
  done.add({"case_hash", c.runs[0].case_hash, {}, {}});
  done.add({"duration_s", c.runs[0].spec.output.duration, {}, {}});
  done.add({"steady_column", std::string("runup_p99_m"), {}, {}});
  EXPECT_TRUE(is_whole_run(done, c.runs[0].spec));
  EXPECT_FALSE(is_whole_run(done, c.runs[1].spec)) << "it is to be measured again";
}

TEST(Campaign, RefusesFaultyCasesAllAtOnceAndNamesThatTwoShare) {
  try {
    (void)campaign_of("[parameters]\n\"numerics.cfl\" = [7.0, 0.4, 8.0]\n\"material.poisson_ratio\" = [0.9, 0.1]\n");
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    const std::string reported = error.what();
    for (const char* part :
         {"cfl = 7", "cfl = 8", "poisson_ratio = 0.9", "plan.toml: numerics.cfl=7.0: ", "(run cfl7_poisson_ratio0.9 and 2 more)"})
      EXPECT_TRUE(contains(reported, part)) << part << "\n in \n" << reported;
  }
  try {
    (void)campaign_of("[[run]]\nname = \"a\"\nset = { \"numerics.cfl\" = 0.2 }\n[[run]]\nname = \"A\"\n");
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_TRUE(contains(error.what(), "two runs are called A, and differ in numerics.cfl")) << error.what();
  }
}

TEST_F(CampaignFolder, TellsWhatIsDoneRunningFailedAndToDo) {
  const Campaign c = campaign_of("[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.25]\n\"numerics.cfl\" = [0.2, 0.4]\n");
  prepare(out(), c);
  EXPECT_EQ(status_of(out(), c.runs[0]).state, RunState::to_do);
  compute(out(), c.runs[0]);
  prepare_run(out(), c.runs[1]);
  prepare_run(out(), c.runs[2]);
  Attempt failure;
  failure.outcome = "failed";
  failure.cause = "why";
  write_attempts(run_directory(out(), c.runs[1]), c.runs[1], {failure});
  const DirectoryLock lock(run_directory(out(), c.runs[2]));
  const auto status = status_of(out(), c);
  EXPECT_EQ(status[0].state, RunState::done);
  EXPECT_EQ(status[0].progress, 1.0);
  EXPECT_EQ(status[1].state, RunState::failed);
  EXPECT_EQ(status[1].cause(), "why");
  EXPECT_EQ(status[2].state, RunState::running);
  EXPECT_EQ(status[3].state, RunState::to_do);
  const CampaignCost cost = cost_of(c, status);
  EXPECT_TRUE(cost.measured);
  EXPECT_DOUBLE_EQ(cost.left, c.runs[2].cost.particle_steps + c.runs[3].cost.particle_steps);  // a failed run is not waited for
}

TEST_F(CampaignFolder, RunsAgainOnlyWhatChangedAndTakesOverWhatWasRenamed) {
  const Campaign before = campaign_of(two_sizes);
  prepare(out(), before);
  for (const CampaignRun& run : before.runs) compute(out(), run);
  // dx0.5 is now another case, dx0.25 has another name, dx0.125 is new
  const Campaign after = campaign_of(
      "[[run]]\nname = \"dx0.5\"\nset = { \"numerics.cell_size_m\" = 0.5, \"numerics.cfl\" = 0.2 }\n"
      "[[run]]\nname = \"renamed\"\nset = { \"numerics.cell_size_m\" = 0.25 }\n"
      "[[run]]\nname = \"dx0.125\"\nset = { \"numerics.cell_size_m\" = 0.125 }\n");
  fs::create_directory(out() / "runs" / "stranger");
  const Preparation p = compare_with_folder(out(), after);
  EXPECT_EQ(p.replaced, (std::vector<std::string>{"dx0.5"}));
  EXPECT_EQ(p.adopted, (std::vector<std::string>{"renamed (was dx0.25)"}));
  EXPECT_EQ(p.dropped, (std::vector<std::string>{"stranger"}));
  prepare(out(), after);
  EXPECT_FALSE(fs::exists(out() / "runs" / "dx0.25"));
  EXPECT_EQ(status_of(out(), after.runs[0]).state, RunState::to_do);
  EXPECT_EQ(status_of(out(), after.runs[1]).state, RunState::done);
  EXPECT_EQ(status_of(out(), after.runs[2]).state, RunState::to_do);
  prepare_run(out(), after.runs[0]);  // nothing of the old case is left to be taken for the new one, and it is kept
  EXPECT_TRUE(finished_results(out() / "runs/dx0.5.1", before.runs[0].spec));
  EXPECT_FALSE(fs::exists(out() / "runs/dx0.5/results.json"));
  EXPECT_FALSE(fs::exists(out() / "runs/dx0.5/checkpoint.h5"));
  EXPECT_EQ(case_hash_text(read_case(out() / "runs/dx0.5/case.toml")), after.runs[0].case_hash);
  // the resolved plan is the plan
  EXPECT_EQ(write_plan(make_campaign(read_plan(out() / "plan.toml")).plan), read_file(out() / "plan.toml"));
}

TEST_F(CampaignFolder, ALongerDurationGoesOnAndAShorterOneStartsAnew) {
  const auto lasting = [](const char* s) {
    return campaign_of(std::string("[[run]]\nname = \"a\"\nset = { \"output.duration_s\" = ") + s + " }\n");
  };
  compute(out(), lasting("0.03").runs[0]);
  EXPECT_EQ(status_of(out(), lasting("0.05").runs[0]).state, RunState::to_do);
  EXPECT_NEAR(status_of(out(), lasting("0.05").runs[0]).progress, 0.6, 1e-12);
  prepare_run(out(), lasting("0.05").runs[0]);
  EXPECT_TRUE(fs::exists(out() / "runs/a/checkpoint.h5"));
  prepare_run(out(), lasting("0.02").runs[0]);
  EXPECT_FALSE(fs::exists(out() / "runs/a/checkpoint.h5"));
}

TEST_F(CampaignFolder, FinishedRunsOfAnEarlierPlanAreKeptAndFoundAgain) {
  const Campaign before = campaign_of(two_sizes), after = campaign_of("[set]\n\"numerics.cfl\" = 0.2\n" + std::string(two_sizes));
  for (const Campaign* campaign : {&before, &after}) {
    prepare(out(), *campaign);
    for (const CampaignRun& run : campaign->runs) {
      compute(out(), run);
      tidy_run(out(), campaign->plan, run);
    }
  }
  for (const auto& [campaign, folder] : {std::pair(&before, 1), std::pair(&after, 2)}) {
    const Preparation p = prepare(out(), *campaign);
    EXPECT_EQ(p.adopted, (std::vector{fmt::format("dx0.5 (was dx0.5.{})", folder), fmt::format("dx0.25 (was dx0.25.{})", folder)}));
    for (const RunStatus& s : status_of(out(), *campaign)) EXPECT_EQ(s.state, RunState::done);
  }
  // a longer one of them begins at the start, without its state, and must not destroy them before it has results of its own
  const Campaign longer = campaign_of("[set]\n\"numerics.cfl\" = 0.2\n\"output.duration_s\" = 0.03\n" + std::string(two_sizes));
  prepare(out(), longer);
  prepare_run(out(), longer.runs[0]);
  EXPECT_TRUE(finished_results(out() / "runs/dx0.5.2", after.runs[0].spec));
}

TEST_F(CampaignFolder, TheTableOfItsStoredResultsIsNotOverwritten) {
  const Campaign first = campaign_of(two_sizes);
  prepare(out(), first);
  write_campaign_tables(out(), first, status_of(out(), first));
  const Campaign again =
      make_campaign(parse_plan("stored_results = [\"out/results.csv\"]\n" + blocks + two_sizes, directory_ / "plan.toml"));
  EXPECT_THROW(prepare(out(), again), ConfigError);
}

TEST_F(CampaignFolder, ADamagedFileOfOneRunIsItsFailureAndIsNamed) {
  const Campaign c = campaign_of(two_sizes);
  prepare(out(), c);
  for (const CampaignRun& run : c.runs) compute(out(), run);
  write_attempts(run_directory(out(), c.runs[0]), c.runs[0], {});
  const auto head = [&](const std::string& rest) {
    return fmt::format("{{\"case_hash\": \"{}\", \"end_s\": 0.02{}}}", c.runs[0].case_hash, rest);
  };
  struct Damage {
    std::string file, text;
    bool harmless = false;
  };
  const std::vector<Damage> damages{{"attempts.json", "{\"case_hash\": 5}"},
                                    {"attempts.json", head(", \"attempts\": 5")},
                                    {"attempts.json", head(", \"attempts\": [1]")},
                                    {"attempts.json", head(", \"attempts\": [{\"started\": 5}]")},
                                    {"attempts.json", head(", \"attempts\": [{\"final\": \"no\"}]")},
                                    {"attempts.json", head("")},
                                    {"attempts.json", "[]"},
                                    {"attempts.json", "{\"case_hash\": \"\xff\"}"},
                                    {"attempts.json", std::string(1000, '[')},
                                    {"results.json", "[]"},
                                    {"results.json", ""},
                                    {"results.json", "{\"title\": \"\xff\"}"},
                                    {"results.json", std::string(1000, '[')}};
  const fs::path folder = run_directory(out(), c.runs[0]);
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.file + " " + damage.text.substr(0, 100));
    const std::string whole = read_file(folder / damage.file);
    write_file(folder / damage.file, damage.text);
    said_.clear();
    EXPECT_EQ(run_with(c, "exit 5\n").failed, 1u);
    EXPECT_TRUE(contains(said_, (folder / damage.file).string())) << said_;
    const std::vector<RunStatus> status = status_of(out(), c);
    EXPECT_EQ(status[0].state, RunState::failed);
    EXPECT_EQ(status[1].state, RunState::done);
    write_campaign_tables(out(), c, status);
    EXPECT_TRUE(contains(Table::read(out() / "results.csv").text("cause")[0], damage.file));
    write_file(folder / damage.file, whole);
    EXPECT_EQ(status_of(out(), c)[0].state, RunState::done);
  }
  // a value of another type that no decision needs, in a file of an older version, which has no checksums
  std::string results = read_file(folder / "results.json");
  for (std::size_t at = 0; (at = results.find("crc32", at)) != std::string::npos;) results.replace(at, 5, "other");
  const std::size_t at = results.find("\"wall_time_s\": ") + 15;
  write_file(folder / "results.json", results.replace(at, results.find(',', at) - at, "\"long\""));
  EXPECT_TRUE(cost_of(c, status_of(out(), c)).measured);
  EXPECT_EQ(run_with(c, "exit 5\n").failed, 0u);
}

TEST_F(CampaignFolder, TheCauseOfAWrongArgumentIsTheMessageAndNotTheHintBehindIt) {
  const Campaign c = campaign_of("[[run]]\nname = \"a\"\n");
  EXPECT_EQ(run_with(c, "printf -- '--threads: 99 is too many\\nRun with --help for more information.\\n' >&2; exit 2\n").failed, 1u);
  EXPECT_EQ(status_of(out(), c.runs[0]).cause(), "exit code 2: --threads: 99 is too many");
}

TEST_F(CampaignFolder, ACauseWithBytesOfAnotherEncodingIsRecordedAndRead) {
  const Campaign c = campaign_of("[[run]]\nname = \"a\"\n");
  EXPECT_EQ(run_with(c, "printf 'cannot read Sch\\344tze.csv\\n' >&2; exit 3\n").failed, 1u);
  EXPECT_EQ(status_of(out(), c.runs[0]).cause(), "exit code 3: cannot read Sch?tze.csv");
  EXPECT_EQ(run_with(c, "exit 0\n").failed, 0u);  // a second call reads the record
  write_campaign_tables(out(), c, status_of(out(), c));
  EXPECT_EQ(Table::read(out() / "results.csv").text("cause")[0], "exit code 3: cannot read Sch?tze.csv");
}

TEST_F(CampaignFolder, TidiesWhatThePlanDoesNotKeep) {
  Campaign c = campaign_of(two_sizes);
  compute(out(), c.runs[0]);
  const fs::path folder = run_directory(out(), c.runs[0]);
  c.plan.keep_final = true;
  tidy_run(out(), c.plan, c.runs[0]);
  EXPECT_TRUE(fs::exists(folder / "final.h5"));
  EXPECT_FALSE(fs::exists(folder / "checkpoint.h5"));
  c.plan.keep_final = false;
  tidy_run(out(), c.plan, c.runs[0]);
  EXPECT_FALSE(fs::exists(folder / "final.h5"));
  EXPECT_EQ(status_of(out(), c.runs[0]).state, RunState::done);
}

TEST_F(CampaignFolder, TheTableIsTheSameWhateverTheOrderAndTimes) {
  const Campaign c = campaign_of("[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.25]\n\"material.poisson_ratio\" = [0.1, 0.2]\n");
  for (const std::vector<std::size_t>& order : {std::vector<std::size_t>{0, 1, 2, 3}, std::vector<std::size_t>{2, 0, 3, 1}}) {
    const fs::path folder = out() / std::to_string(order[0]);
    prepare(folder, c);
    for (const std::size_t i : order) {
      compute(folder, c.runs[i]);
      write_campaign_tables(folder, c, status_of(folder, c));
    }
  }
  const std::string table = read_file(out() / "0/results.csv");
  EXPECT_EQ(table, read_file(out() / "2/results.csv"));
  const Table t = Table::read(out() / "0/results.csv");
  EXPECT_EQ(t.text("name"), (std::vector<std::string>{"dx0.5_poisson_ratio0.1", "dx0.5_poisson_ratio0.2", "dx0.25_poisson_ratio0.1",
                                                      "dx0.25_poisson_ratio0.2"}));
  EXPECT_EQ(t.text("run")[0], "runs/dx0.5_poisson_ratio0.1");
  EXPECT_EQ(t.numbers("cell_size_m"), (std::vector{0.5, 0.5, 0.25, 0.25}));
  EXPECT_EQ(t.numbers("material.poisson_ratio"), (std::vector{0.1, 0.2, 0.1, 0.2}));
  EXPECT_EQ(t.numbers("particles_final"), (std::vector{64.0, 64.0, 512.0, 512.0}));
  EXPECT_EQ(t.text("precision"), std::vector<std::string>(4, "double"));
  const Table executions = Table::read(out() / "0/runs.csv");
  const std::set<std::string> about_the_run{"case_hash", "version", "commit", "precision", "steady_column"};
  const std::set<std::string> of_the_stop_rule{"stop_when_steady", "stopped_when_steady"};  // no run of this plan has it
  const std::set<std::string> of_the_files{"title", "format_version", "series_crc32", "profile_crc32", "crc32"};
  for (const std::string& entry : run_entries(Nature::execution)) {
    EXPECT_EQ(t.has(entry), about_the_run.contains(entry)) << entry << " is no result of the simulation";
    if (of_the_stop_rule.contains(entry)) continue;
    EXPECT_EQ(executions.has(entry), !about_the_run.contains(entry) && !of_the_files.contains(entry)) << entry;
  }
  for (const std::string& entry : run_entries(Nature::physics)) EXPECT_FALSE(executions.has(entry)) << entry;
}

class StoredResultsOfACampaign : public CampaignFolder {
 protected:
  void SetUp() override {
    const Campaign first = campaign_of(two_sizes);
    prepare(out(), first);
    for (const CampaignRun& run : first.runs) compute(out(), run);
    write_campaign_tables(out(), first, status_of(out(), first));
    fs::copy_file(out() / "results.csv", directory_ / "earlier.csv");
    table_ = read_file(directory_ / "earlier.csv");
  }

  [[nodiscard]] Campaign with_earlier(const std::string& more) const {
    return make_campaign(parse_plan("stored_results = [\"earlier.csv\"]\n" + blocks + more, directory_ / "plan.toml"));
  }

  /// How many runs are done by the stored rows alone, in a folder that is empty.
  [[nodiscard]] std::size_t done_by_rows(const Campaign& campaign) const {
    const std::vector<RunStatus> status = status_of(directory_ / "empty", campaign);
    for (const RunStatus& s : status) EXPECT_EQ(s.state, s.stored ? RunState::done : RunState::to_do);
    return static_cast<std::size_t>(std::ranges::count(status, true, &RunStatus::stored));
  }

  std::string table_;
};

TEST_F(StoredResultsOfACampaign, TakeThePlaceOfItsRunsByteForByte) {
  const Campaign again = with_earlier(two_sizes);
  EXPECT_EQ(done_by_rows(again), 2u);
  EXPECT_EQ(again.unused_rows, 0u);
  const fs::path elsewhere = directory_ / "elsewhere";
  prepare(elsewhere, again);
  EXPECT_EQ(execute(again, {0, 1}, {elsewhere, program("exit 1\n"), 1, false, {}, {}, {}}).failed, 0u);  // starts nothing
  write_campaign_tables(elsewhere, again, status_of(elsewhere, again));
  EXPECT_EQ(read_file(elsewhere / "results.csv"), table_);
  EXPECT_FALSE(cost_of(again, status_of(elsewhere, again)).measured);  // no run here has shown a speed

  const Campaign resolved = make_campaign(read_plan(elsewhere / "plan.toml"));  // as a task of a Slurm array reads it
  EXPECT_EQ(done_by_rows(resolved), 2u);
}

TEST_F(StoredResultsOfACampaign, StandBesideRunsOfTheFolder) {
  const Campaign wider = with_earlier("[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.4, 0.25]\n");
  EXPECT_EQ(done_by_rows(wider), 2u);
  const fs::path elsewhere = directory_ / "elsewhere";
  prepare(elsewhere, wider);
  compute(elsewhere, wider.runs[1]);
  write_campaign_tables(elsewhere, wider, status_of(elsewhere, wider));
  const Table all = Table::read(elsewhere / "results.csv"), earlier = Table::read(directory_ / "earlier.csv");
  EXPECT_EQ(all.columns(), earlier.columns());
  EXPECT_EQ(all.text("status"), std::vector<std::string>(3, "done"));
  EXPECT_EQ(all.numbers("particles_final")[0], earlier.numbers("particles_final")[0]);
  // a run of the folder counts before a row of the same case
  compute(elsewhere, wider.runs[0]);
  EXPECT_FALSE(status_of(elsewhere, wider.runs[0]).stored);
}

TEST_F(StoredResultsOfACampaign, AreNotThoseOfAnotherCaseOrDuration) {
  const Campaign other = with_earlier("[set]\n\"numerics.cfl\" = 0.2\n" + std::string(two_sizes));
  EXPECT_EQ(done_by_rows(other), 0u);
  EXPECT_EQ(other.unused_rows, 2u);
  EXPECT_EQ(done_by_rows(with_earlier("[set]\n\"output.duration_s\" = 0.03\n" + std::string(two_sizes))), 0u);

  std::string failed = table_;
  for (std::size_t at = failed.find(",done,"); at != std::string::npos; at = failed.find(",done,")) failed.replace(at, 6, ",to do,");
  write_file(directory_ / "earlier.csv", failed);
  EXPECT_EQ(done_by_rows(with_earlier(two_sizes)), 0u);
}

TEST_F(StoredResultsOfACampaign, MustBeATableOfResults) {
  write_file(directory_ / "earlier.csv", "name,status\na,done\n");
  EXPECT_THROW((void)with_earlier(two_sizes), IoError);
  fs::remove(directory_ / "earlier.csv");
  try {
    (void)with_earlier(two_sizes);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_TRUE(contains(error.what(), "stored_results: there is no file \"earlier.csv\"")) << error.what();
  }
}

TEST(StoredResults, OfARunThatEndedWhenItsMeansWereKnownCountForAPlanOfTheSameOrALargerLimit) {
  const testing::TemporaryDirectory directory;
  const auto run_of_plan = [&](double limit) {
    const std::string plan =
        fmt::format("{}[set]\n\"output.stop_when_steady\" = {}\n[[run]]\nname = \"a\"\n", testing::avalanche_plan, limit);
    return make_campaign(parse_plan("stored_results = [\"rows.csv\"]\n" + plan, directory / "plan.toml")).runs[0];
  };
  std::ofstream(directory / "rows.csv") << "case_hash,status\n";
  const std::string hash = run_of_plan(0.02).case_hash;
  const auto stored = [&](const std::string& row, double limit) {
    std::ofstream(directory / "rows.csv") << "case_hash,status,duration_s,stop_when_steady,stopped_when_steady\n"
                                          << hash << "," << row << "\n";
    return run_of_plan(limit).stored_results.has_value();
  };
  EXPECT_TRUE(stored("done,0.3,0.02,1", 0.02));
  EXPECT_TRUE(stored("done,0.3,0.02,1", 0.05));
  EXPECT_FALSE(stored("done,0.3,0.02,1", 0.01));
  EXPECT_FALSE(stored("done,0.3,0.02,0", 0.02));  // cut off before its end
  EXPECT_FALSE(stored("done,0.3,,", 0.02));
}

TEST_F(CampaignFolder, AFailureThatNeedNotRepeatItselfIsTriedAgain) {
  const Campaign c = campaign_of("[[run]]\nname = \"a\"\n");
  // fails at first; then writes the requested files
  const std::string script = "if [ -e \"$4/second\" ]; then echo 'disk full' >&2; exit 4; fi\ntouch \"$4/second\"\nkill -9 $$\n";
  const ExecutionReport report = run_with(c, script);
  EXPECT_TRUE(report.finished);
  EXPECT_EQ(report.failed, 1u);
  const RunStatus status = status_of(out(), c.runs[0]);
  EXPECT_EQ(status.state, RunState::failed);
  ASSERT_EQ(status.attempts.size(), 2u);
  EXPECT_EQ(status.attempts[0].signal, SIGKILL);
  EXPECT_TRUE(contains(status.attempts[0].cause, "ended by signal 9"));
  EXPECT_EQ(status.attempts[1].exit_code, 4);
  EXPECT_EQ(status.cause(), "exit code 4: disk full");
  EXPECT_TRUE(contains(said_, "is tried again"));
  write_campaign_tables(out(), c, status_of(out(), c));
  EXPECT_EQ(Table::read(out() / "results.csv").text("cause")[0], "exit code 4: disk full");
}

TEST_F(CampaignFolder, AnUnstableRunIsNotTriedAgainUnlessAskedAndARefusedOneByTheNextCall) {
  const Campaign c = campaign_of(two_sizes);
  const std::string script = "echo progress >&2; echo 'particle 7 left the earth' >&2; case \"$4\" in *dx0.5) exit 3;; *) exit 2;; esac\n";
  EXPECT_EQ(run_with(c, script).failed, 2u);
  for (const CampaignRun& run : c.runs) {
    const RunStatus status = status_of(out(), run);
    ASSERT_EQ(status.attempts.size(), 1u);
    EXPECT_EQ(status.attempts[0].final, status.attempts[0].exit_code == 3);
    EXPECT_TRUE(contains(status.cause(), "particle 7 left the earth"));
  }
  EXPECT_EQ(run_with(c, script).failed, 1u);  // of a second call: what refused the other may have changed
  EXPECT_EQ(status_of(out(), c.runs[0]).attempts.size(), 1u);
  EXPECT_TRUE(contains(said_, "failed before, and would again"));
  EXPECT_EQ(run_with(c, script, true).failed, 2u);
  EXPECT_EQ(status_of(out(), c.runs[0]).attempts.size(), 2u);
}

TEST_F(CampaignFolder, AStopReachesTheChildrenAndIsNoFailure) {
  const Campaign c = campaign_of(two_sizes);
  prepare(out(), c);
  ExecutionOptions options{out(), program("touch \"$4/here\"\nexec sleep 60\n"), 2, false, {}, {}, {}};
  options.poll = [&] {
    const bool both = fs::exists(run_directory(out(), c.runs[0]) / "here") && fs::exists(run_directory(out(), c.runs[1]) / "here");
    return both ? Request::stop : Request::none;
  };
  const ExecutionReport report = execute(c, {0, 1}, options);
  EXPECT_FALSE(report.finished);
  EXPECT_EQ(report.failed, 0u);
  for (const CampaignRun& run : c.runs) {
    const RunStatus status = status_of(out(), run);
    EXPECT_EQ(status.state, RunState::to_do);
    EXPECT_EQ(status.attempts.at(0).outcome, "stopped");
  }
}

TEST_F(CampaignFolder, WaitsForAProcessThatWorksInARunsFolder) {
  const Campaign c = campaign_of("[[run]]\nname = \"a\"\n");
  prepare_run(out(), c.runs[0]);
  auto lock = std::make_unique<DirectoryLock>(run_directory(out(), c.runs[0]));
  ExecutionOptions options{out(), program("exit 5\n"), 1, false, {}, {}, {}};
  int asked = 0;
  options.poll = [&] {
    if (++asked == 5) {  // it ends, and has done the run
      lock.reset();
      compute(out(), c.runs[0]);
    }
    return Request::none;
  };
  options.say = [this](const std::string& line) { said_ += line + "\n"; };
  const ExecutionReport report = execute(c, {0}, options);
  EXPECT_TRUE(report.finished);
  EXPECT_EQ(report.failed, 0u);
  EXPECT_TRUE(status_of(out(), c.runs[0]).attempts.empty());  // not started here
  EXPECT_TRUE(contains(said_, "another process works on it"));
}

TEST(CampaignMemory, RefusesMoreAtATimeThanThereIsRoomFor) {
  const Campaign c = campaign_of(two_sizes);
  const double largest = c.runs[1].cost.memory_bytes, both = largest + c.runs[0].cost.memory_bytes;
  EXPECT_NO_THROW(require_memory(c, 2, both));
  EXPECT_NO_THROW(require_memory(c, 1, largest));
  const auto message = [&](int jobs, double limit) {
    try {
      require_memory(c, jobs, limit);
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(message(2, 0.99 * both).find("give a smaller --jobs"), std::string::npos) << message(2, 0.99 * both);
  // one run at a time is too many: fewer are not possible
  EXPECT_EQ(message(1, 0.99 * largest).find("--jobs"), std::string::npos) << message(1, 0.99 * largest);
  EXPECT_NE(message(1, 0.99 * largest).find("numerics.cell_size_m"), std::string::npos) << message(1, 0.99 * largest);
}

TEST_F(CampaignFolder, ALauncherStartsTheRanksOfARun) {
  const fs::path launcher = directory_ / "launcher.sh";
  std::ofstream(launcher) << "#!/bin/sh\necho \"$@\" >" << (directory_ / "words").string() << "\nshift\nexec \"$@\"\n";
  fs::permissions(launcher, fs::perms::owner_all);
  const std::string keys = fmt::format("ranks = 3\nlauncher = [\"{}\", \"-n={{ranks}}\"]\n", launcher.string());
  const Campaign campaign = make_campaign(parse_plan(keys + blocks + two_sizes, "plan.toml"));
  const ExecutionReport report = run_with(campaign, "exit 137\n");  // as where a signal has ended a rank
  EXPECT_EQ(report.failed, 2u);
  EXPECT_TRUE(contains(said_, "ended by signal 9")) << said_;
  const std::string words = read_file(directory_ / "words");
  EXPECT_TRUE(words.starts_with("-n=3 " + (directory_ / "program.sh").string() + " run ")) << words;

  CampaignPlan missing = campaign.plan;
  missing.launcher = {"no-such-launcher", "{ranks}"};
  EXPECT_THROW(run_with(make_campaign(missing), ""), ConfigError);
}

TEST_F(CampaignFolder, TheSlurmScriptAsksForWhatThePlanSays) {
  CampaignPlan plan = parse_plan(
      "ranks = 8\nthreads = 4\n[slurm]\npartition = \"main\"\ntime_limit = \"01:00:00\"\nmemory = \"2G\"\n"
      "options = [\"--constraint=avx512\"]\n" +
          blocks.substr(blocks.find('\n') + 1) + two_sizes,
      "plan.toml");
  const std::vector<std::string> names{"a", "b", "c"};
  const SlurmJob job = write_slurm_job(plan, "it's", names, out(), "/opt/my mpm", 2);
  EXPECT_EQ(read_file(job.tasks), "a\nb\nc\n");
  const std::string script = read_file(job.script);
  for (const char* line :
       {"--array=1-3%2\n", "--ntasks=8\n", "--cpus-per-task=4\n", "--partition='main'\n", "--time='01:00:00'\n", "--mem='2G'\n",
        "--constraint=avx512\n", "--requeue\n", "--job-name='it'\\''s'\n", "exec '/opt/my mpm' campaign task "})
    EXPECT_TRUE(contains(script, line)) << line << "\n in \n" << script;
  EXPECT_NE(write_slurm_job(plan, "x", names, out(), "mpm", 0).script, job.script);
  EXPECT_FALSE(contains(read_file(out() / "slurm/job_2.sh"), "%2"));
}

TEST_F(CampaignFolder, NothingInTheSlurmScriptBecomesACommandOfItsOwn) {
  const std::vector<std::string> names{"a"};
  const CampaignPlan plan = parse_plan(blocks + two_sizes, "plan.toml");
  const auto refused = [&](const CampaignPlan& p, const std::string& name, const fs::path& folder) {
    EXPECT_THROW((void)write_slurm_job(p, name, names, folder, "mpm", 0), ConfigError);
    EXPECT_FALSE(fs::exists(folder / "slurm/job_1.sh"));
  };
  const std::string evil = "x\ntouch hacked\n";
  for (auto key : {&SlurmSpec::partition, &SlurmSpec::account, &SlurmSpec::qos, &SlurmSpec::time_limit, &SlurmSpec::memory}) {
    CampaignPlan p = plan;
    p.slurm.*key = evil;
    refused(p, "job", out());
  }
  CampaignPlan p = plan;
  p.slurm.options = {"--constraint=a\ntouch hacked"};
  refused(p, "job", out());
  refused(plan, evil, out());
  refused(plan, "job", directory_ / "a\ntouch hacked");
  EXPECT_NO_THROW((void)write_slurm_job(plan, "job", names, out(), "mpm", 0));
}

}  // namespace
}  // namespace mpm
