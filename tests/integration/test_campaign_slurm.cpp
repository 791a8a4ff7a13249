/// A campaign through Slurm, on a cluster of this machine alone that the test starts itself.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "libmpm/io/csv.hpp"
#include "support/slurm.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;

using testing::contains;
using testing::content;
using testing::Outcome;

/// One run fails: sound travels at millimetres a second and the block at 900 m/s, and its time step collapses.
const std::string blocks = std::string("title = \"Blocks\"\n") + testing::falling_block_plan + R"([parameters]
"numerics.cell_size_m" = [0.5, 0.25]
"material.poisson_ratio" = [0.1, 0.2]
[[run]]
name = "wild"
set = { "body[0].velocity_m_s" = [900, 0, 0], "material.young_modulus_pa" = 1, "material.density_kg_m3" = 1e5 }
)";

class CampaignSlurm : public testing::SlurmTest {
 protected:
  void SetUp() override {
    testing::SlurmTest::SetUp();
    std::ofstream(directory_ / "plan.toml") << blocks;
  }
};

TEST_F(CampaignSlurm, LeavesTheTableOfALocalCampaignAndSubmitsOnlyWhatIsNotDone) {
  const Outcome local = campaign("run plan.toml --out local");
  EXPECT_EQ(local.code, 1) << local.err;  // the wild one
  const std::string table = content(directory_ / "local/results.csv");
  EXPECT_EQ(Table::read(directory_ / "local/results.csv").text("status"),
            (std::vector<std::string>{"done", "done", "done", "done", "failed"}));

  const Outcome waited = campaign("run plan.toml --out waited --executor slurm --jobs 2");
  EXPECT_EQ(waited.code, 1) << waited.err;
  EXPECT_TRUE(contains(waited.err, "5 tasks")) << waited.err;
  EXPECT_TRUE(contains(waited.out, "4 done, 0 running, 1 failed, 0 to do")) << waited.out;
  EXPECT_EQ(content(directory_ / "waited/results.csv"), table);

  // one folder is lost: it alone is submitted, and status sees and tabulates what the tasks did
  fs::remove_all(directory_ / "waited/runs/dx0.5_poisson_ratio0.2");
  const Outcome submitted = campaign("submit plan.toml --out waited");
  EXPECT_EQ(submitted.code, 0) << submitted.err;
  EXPECT_TRUE(contains(submitted.err, ": 1 task (")) << submitted.err;
  while (!with_slurm("squeue --noheader").out.empty()) usleep(100000);  // as long as Slurm works on it
  const Outcome status = campaign("status plan.toml --out waited");
  EXPECT_TRUE(contains(status.out, "4 done, 0 running, 1 failed, 0 to do")) << status.out;
  EXPECT_EQ(content(directory_ / "waited/results.csv"), table);

  const Outcome nothing = campaign("submit plan.toml --out waited");
  EXPECT_TRUE(contains(nothing.err, "nothing to submit")) << nothing.err;
  EXPECT_EQ(nothing.code, 1);  // a run has failed
}

TEST_F(CampaignSlurm, SaysWhatSbatchRefuses) {
  std::ofstream(directory_ / "plan.toml", std::ios::app) << "[slurm]\npartition = \"nowhere\"\n";
  const Outcome o = campaign("submit plan.toml --out refused");
  EXPECT_EQ(o.code, 4) << o.err;
  EXPECT_TRUE(contains(o.err, "sbatch did not take")) << o.err;
  EXPECT_TRUE(contains(o.err, "invalid partition")) << o.err;
}

}  // namespace
}  // namespace mpm
