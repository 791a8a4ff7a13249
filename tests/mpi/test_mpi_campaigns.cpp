/// Campaigns and grid studies whose runs have several ranks.

#include <csignal>
#include <fstream>

#include "libmpm/io/csv.hpp"
#include "support/mpi.hpp"
#include "support/rank_cases.hpp"
#include "support/rank_files.hpp"
#include "support/slurm.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;
using testing::contains;
using testing::content;
using testing::Outcome;

const std::string blocks = std::string("title = \"Blocks\"\n") + testing::falling_block_plan;
const std::string two_sizes = "[parameters]\n\"numerics.cell_size_m\" = [0.5, 0.25]\n";

class MpiCampaign : public testing::MpiTest {
 protected:
  [[nodiscard]] Outcome mpm(const std::string& before, const std::string& arguments) const {
    return testing::run_command(before + " '" MPM_APP "' " + arguments, directory_.path(), directory_.path());
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(directory_ / name) << text; }

  testing::TemporaryDirectory directory_;
};

TEST_F(MpiCampaign, GivesTheTableOfRunsOnOneRank) {
  write("one.toml", blocks + two_sizes);
  write("two.toml", "ranks = 2\n" + blocks + two_sizes);
  ASSERT_EQ(mpm("", "campaign run one.toml --out one").code, 0);
  const Outcome two = mpm("", "campaign run two.toml --out two --jobs 1");
  ASSERT_EQ(two.code, 0) << two.err;
  const Outcome three = mpm("", "campaign run one.toml --out three --jobs 1 --ranks 3");
  ASSERT_EQ(three.code, 0) << three.err;
  for (const auto& [folder, ranks] : {std::pair{"two", "2"}, std::pair{"three", "3"}}) {
    EXPECT_EQ(content(directory_ / folder / "results.csv"), content(directory_ / "one/results.csv"));
    EXPECT_EQ(Table::read(directory_ / folder / "runs.csv").text("ranks"), std::vector<std::string>(2, ranks));
  }
}

TEST_F(MpiCampaign, TellsWhyARunOfSeveralRanksFailed) {
  write("plan.toml", "ranks = 2\n" + blocks +
                         "[[run]]\nname = \"wild\"\nset = { \"body[0].velocity_m_s\" = [900, 0, 0], \"material.young_modulus_pa\" = 1, "
                         "\"material.density_kg_m3\" = 1e5 }\n");
  const Outcome outcome = mpm("", "campaign run plan.toml --out out");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.err, "wild: failed: exit code 3: ")) << outcome.err;  // not tried again, as it would fail again
  EXPECT_TRUE(contains(outcome.err, "the time step collapsed")) << outcome.err;
}

TEST_F(MpiCampaign, StopsWithACheckpoint) {
  write("plan.toml", "ranks = 2\n" + blocks +
                         "[[run]]\nname = \"long\"\nset = { \"numerics.gravity_m_s2\" = 0, \"output.duration_s\" = 100.0, "
                         "\"output.series_per_second\" = 50 }\n");
  const Outcome stopped = testing::run_command("{ '" MPM_APP
                                               "' campaign run plan.toml --out out & child=$!; "
                                               "until [ $(cat out/runs/long/series.csv 2>/dev/null | wc -l) -gt 3 ] || ! kill -0 $child; "
                                               "do sleep 0.05; done; kill -TERM $child; wait $child; }",
                                               directory_.path(), directory_.path());
  EXPECT_TRUE(contains(stopped.err, "stopped; the same command continues")) << stopped.err;
  EXPECT_TRUE(fs::exists(directory_ / "out/runs/long/checkpoint.h5")) << stopped.err;
  EXPECT_TRUE(contains(content(directory_ / "out/runs/long/attempts.json"), "\"stopped\"")) << stopped.err;
  EXPECT_FALSE(fs::exists(directory_ / "out/runs/long/results.json"));
}

TEST_F(MpiCampaign, GridStudiesTakeSeveralRanks) {
  write("case.toml", testing::falling_block_case);
  const std::string study = "converge case.toml --cell-size 0.5,0.25 --metric steps,particles_final --threads 1 --out ";
  const Outcome one = mpm("", study + "one"), two = mpm("", study + "two --ranks 2"), under = mpm(testing::launcher(2), study + "three");
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_EQ(two.code, 0) << two.err;
  EXPECT_EQ(under.code, 2);
  EXPECT_TRUE(contains(under.err, "it starts the ranks of each run itself")) << under.err;
  EXPECT_EQ(one.out, two.out);
  EXPECT_EQ(content(directory_ / "one/converge.csv"), content(directory_ / "two/converge.csv"));
  EXPECT_TRUE(contains(content(directory_ / "two/runs/dx0.25/results.json"), "\"ranks\": 2"));
}

class MpiSlurm : public testing::SlurmTest {
 protected:
  void SetUp() override {
    if (!testing::with_mpi) GTEST_SKIP() << "built without MPI; `./run build mpi` and `ctest --preset mpi -R Mpi` run this";
    setenv("OMPI_MCA_mpi_yield_when_idle", "1", 1);  // as testing::patient
    testing::SlurmTest::SetUp();
  }
};

TEST_F(MpiSlurm, TasksAreTheRanksOfARun) {
  std::ofstream(directory_ / "plan.toml") << blocks + two_sizes;
  ASSERT_EQ(campaign("run plan.toml --out one").code, 0);
  const Outcome two = campaign("run plan.toml --out two --ranks 2 --executor slurm");
  ASSERT_EQ(two.code, 0) << two.err << content(directory_ / "two/runs/dx0.5/stderr.log");
  EXPECT_TRUE(contains(content(directory_ / "two/slurm/job_1.sh"), "--ntasks=2\n"));
  EXPECT_EQ(content(directory_ / "two/results.csv"), content(directory_ / "one/results.csv"));
  EXPECT_EQ(Table::read(directory_ / "two/runs.csv").text("ranks"), std::vector<std::string>(2, "2"));
}

/// Snow on a mast, long enough to be disturbed.
Case avalanche() {
  Case c = testing::with_frames(testing::rank_cases()[5].c);
  c.output.duration = 0.6;
  return c;
}

TEST_F(MpiSlurm, SrunStartsRanks) {
  testing::write_rank_case(directory_ / "case.toml", avalanche());
  const std::string run = "'" MPM_APP "' run case.toml --threads 1 --out ";
  ASSERT_EQ(shell(run + "one").code, 0);
  const Outcome three = with_slurm("srun --mpi=pmix --ntasks=3 " + run + "three");
  ASSERT_EQ(three.code, 0) << three.err;
  testing::expect_same_files(directory_ / "one", directory_ / "three");
  EXPECT_TRUE(contains(content(directory_ / "three/results.json"), "\"ranks\": 3"));
}

TEST_F(MpiSlurm, SrunPassesTheSignalToStopOn) {
  testing::write_rank_case(directory_ / "case.toml", avalanche());
  const std::string run = "'" MPM_APP "' run case.toml --threads 1 --out ";
  ASSERT_EQ(shell(run + "one").code, 0);
  const Outcome stopped =
      with_slurm("sh -c 'srun --mpi=pmix --ntasks=2 " MPM_APP
                 " run case.toml --threads 1 --out stopped & srun=$!; "
                 "until [ $(cat stopped/series.csv 2>/dev/null | wc -l) -gt 3 ] || ! kill -0 $srun; do sleep 0.05; done; "
                 "kill -USR2 $srun; wait $srun'");
  EXPECT_EQ(stopped.code, 128 + SIGUSR2) << stopped.err;
  EXPECT_TRUE(contains(stopped.err, "stopped at t = ")) << stopped.err;
  ASSERT_EQ(shell(run + "stopped --resume").code, 0);
  testing::expect_same_files(directory_ / "one", directory_ / "stopped");
}

/// The job script of docs/cluster.md for this machine: one node, two tasks.
std::string job_script() {
  const std::string page = content(MPM_SOURCE_DIR "/docs/cluster.md");
  const auto first = page.find("#!/bin/bash");
  std::string script = page.substr(first, page.find("```", first) - first);
  for (const auto& [of_the_page, here] : {std::pair{"--nodes=2", "--nodes=1"}, std::pair{"--ntasks-per-node=8", "--ntasks-per-node=2"},
                                          std::pair{"--cpus-per-task=4", "--cpus-per-task=1"}, std::pair{"build/mpi/bin/mpm", MPM_APP}}) {
    const auto at = script.find(of_the_page);
    EXPECT_NE(at, std::string::npos) << of_the_page;
    if (at != std::string::npos) script.replace(at, std::string_view(of_the_page).size(), here);
  }
  return script;
}

TEST_F(MpiSlurm, TheJobScriptOfTheDocumentationWritesACheckpointWhenSlurmSignalsIt) {
  testing::write_rank_case(directory_ / "case.toml", avalanche());
  std::ofstream(directory_ / "job.sh") << job_script();
  ASSERT_EQ(shell("'" MPM_APP "' run case.toml --threads 1 --out one").code, 0);
  const Outcome job = with_slurm(  // the signal is that of --signal=B:USR1
      "sh -c 'job=$(sbatch --parsable job.sh) || exit 1; "
      "queued() { [ -n \"$(squeue --noheader --job $job)\" ]; }; "
      "until [ $(cat out/fr3/series.csv 2>/dev/null | wc -l) -gt 3 ] || ! queued; do sleep 0.05; done; "
      "scancel --batch --signal=USR1 $job; "
      "while queued; do sleep 0.1; done; cat slurm-$job.out'");
  ASSERT_EQ(job.code, 0) << job.err;
  EXPECT_TRUE(contains(content(directory_ / "out/fr3/run.log"), "(asked for)")) << job.out;
  EXPECT_TRUE(contains(content(directory_ / "out/fr3/results.json"), "\"ranks\": 2")) << job.out;
  testing::expect_same_files(directory_ / "one", directory_ / "out/fr3");
}

}  // namespace
}  // namespace mpm
