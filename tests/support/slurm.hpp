#pragma once
/// A Slurm cluster on this machine, started by a test.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <string>

#include "support/command.hpp"
#include "support/temporary_directory.hpp"

namespace mpm::testing {

/// Skipped, with the reason, without Slurm or without root.
class SlurmTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "needs root: Slurm's daemons run as the user whom they serve";
    for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch"}) {
      if (shell(std::string("PATH=$PATH:/usr/sbin command -v ") + program).code != 0)
        GTEST_SKIP() << program << " is not installed (Debian: slurm-wlm)";
    }
    lock_ = open("/tmp/mpm-test-slurm.lock", O_CREAT | O_RDWR | O_CLOEXEC, 0600);
    ASSERT_EQ(flock(lock_, LOCK_EX), 0);  // of two clusters at one time one cannot start the tasks of a job
    const Outcome up = shell(cluster("up"));
    ASSERT_EQ(up.code, 0) << up.err;
    started_ = true;
  }
  void TearDown() override {
    if (started_) {
      EXPECT_EQ(shell(cluster("down")).code, 0);
    }
    if (lock_ >= 0) close(lock_);
  }

  [[nodiscard]] std::string cluster(const std::string& verb) const {
    return "PATH=$PATH:/usr/sbin '" MPM_SOURCE_DIR "/tests/support/slurm_cluster.sh' " + verb + " '" + (directory_ / "slurm").string() +
           "' </dev/null";
  }
  [[nodiscard]] Outcome shell(const std::string& command) const { return run_command(command, directory_.path(), directory_.path()); }
  /// A command with access to the cluster.
  [[nodiscard]] Outcome with_slurm(const std::string& command) const {
    return shell("SLURM_CONF='" + (directory_ / "slurm/slurm.conf").string() + "' " + command);
  }
  [[nodiscard]] Outcome campaign(const std::string& arguments) const { return with_slurm("'" MPM_APP "' campaign " + arguments); }

  TemporaryDirectory directory_;
  bool started_ = false;
  int lock_ = -1;
};

}  // namespace mpm::testing
