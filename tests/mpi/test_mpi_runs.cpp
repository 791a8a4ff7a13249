#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "libmpm/io/atomic_file.hpp"
#include "support/command.hpp"
#include "support/mpi.hpp"
#include "support/rank_cases.hpp"
#include "support/rank_files.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;
using testing::content;
using testing::launcher;
using testing::Outcome;
using testing::run_command;
using testing::TemporaryDirectory;

class MpiRun : public testing::MpiTest {
 protected:
  Outcome mpm(const std::string& before, const std::string& arguments) {
    return run_command(fmt::format("{} {} {}", before, MPM_APP, arguments), folder / "", folder / "");
  }
  Outcome one(const std::string& out, const std::string& more = "") {
    return mpm("", fmt::format("run case.toml --out {} --threads 1 {}", out, more));
  }
  Outcome several(int ranks, int threads, const std::string& out, const std::string& more = "", const std::string& variables = "") {
    return mpm(variables + " " + launcher(ranks), fmt::format("run case.toml --out {} --threads {} {}", out, threads, more));
  }
  void write(const Case& c) { testing::write_rank_case(folder / "case.toml", c); }
  void expect_same_files(const std::string& a, const std::string& b) { testing::expect_same_files(folder / a, folder / b); }

  TemporaryDirectory folder;
};

TEST_F(MpiRun, WritesTheBytesOfOneRank) {
  const std::vector<testing::NamedCase> all = testing::rank_cases();
  struct Way {
    int ranks, threads;
    const char* variables;
  };
  for (const std::size_t n : {2, 6, 8, 11, 14}) {  // test_ranks has all, without processes; tests/mpi/matrix.py with many ways
    const auto& [name, c] = all[n];
    write(testing::with_frames(c));
    const Outcome alone = one(fmt::format("{}_1", name));
    ASSERT_EQ(alone.code, 0) << name << ": " << alone.err;
    for (const Way& way : {Way{2, 1, ""}, Way{3, 2, ""}, Way{4, 1, "MPM_REBALANCE_STEPS=10"}}) {
      const std::string out = fmt::format("{}_{}_{}", name, way.ranks, way.threads);
      const Outcome outcome = several(way.ranks, way.threads, out, "", way.variables);
      ASSERT_EQ(outcome.code, 0) << outcome.err;
      expect_same_files(fmt::format("{}_1", name), out);
    }
  }
}

TEST_F(MpiRun, GoesOnWithAnyNumberOfRanks) {
  Case c = testing::with_frames(testing::rank_cases()[5].c);
  write(c);
  const Outcome whole = one("whole");
  ASSERT_EQ(whole.code, 0) << whole.err;
  const std::string shorter = fmt::format("--set output.duration_s={}", c.output.duration / 3.0);
  const std::string longer = fmt::format("--set output.duration_s={}", 2.0 * c.output.duration / 3.0);
  ASSERT_EQ(several(3, 1, "resumed", shorter).code, 0);
  ASSERT_EQ(one("resumed", longer + " --resume").code, 0);
  const Outcome last = several(2, 2, "resumed", "--resume");
  ASSERT_EQ(last.code, 0) << last.err;
  expect_same_files("whole", "resumed");
}

TEST_F(MpiRun, AKilledRankEndsTheRunAndResumeLosesNothing) {
  Case c = testing::with_frames(testing::rank_cases()[5].c);
  c.output.duration = 0.3;
  c.output.checkpoint_minutes = 1e-9;  // at every sample
  write(c);
  const Outcome whole = one("whole");
  ASSERT_EQ(whole.code, 0) << whole.err;
  int killed_in_the_run = 0;
  for (int kill = 0; kill < 4; ++kill) {
    const std::string out = fmt::format("killed_{}", kill);
    const int victim = kill % 3, rows = 2 + 3 * kill;  // of 15
    // the launcher starts a shell for each rank, which notes its rank's process
    const std::string command = fmt::format(
        "({}bash -c 'echo $$ > {}.pid.$OMPI_COMM_WORLD_RANK; exec {} run case.toml --out {} --threads 1' & launcher=$!; "
        "for i in $(seq 3000); do [ $(cat {}/series.csv 2>/dev/null | wc -l) -gt {} ] && break; sleep 0.01; done; "
        "kill -KILL $(cat {}.pid.{}) ; wait $launcher)",
        launcher(3), out, MPM_APP, out, out, rows, out, victim);
    const auto start = std::chrono::steady_clock::now();
    const Outcome killed = run_command(command, folder / "", folder / "");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60)) << "the others went on waiting";
    // a rank may also be killed between its last file and its end, so that a finished run need not end with 0
    const bool finished = fs::exists(folder / out / "results.json");
    EXPECT_TRUE(finished || killed.code != 0) << killed.err;
    killed_in_the_run += finished ? 0 : 1;
    const Outcome resumed = several(kill % 2 == 0 ? 2 : 4, 1, out, "--resume");
    ASSERT_EQ(resumed.code, 0) << resumed.err;
    expect_same_files("whole", out);
  }
  EXPECT_GT(killed_in_the_run, 0) << "no kill came before the end of its run, so nothing was checked";
}

TEST_F(MpiRun, AnUnstableRunEndsOnAllRanksWithOneMessage) {
  Case c = testing::empty_case();  // two blocks that meet after 0.06 s at fifty times the speed of sound
  c.bodies = {testing::box_body(Vec3::Zero(), Vec3::Constant(0.5)),
              testing::box_body({50.0, 0.0, 0.0}, {50.5, 0.5, 0.5}, {-900.0, 0.0, 0.0})};
  c.domain.max.x() = 60.0;
  c.numerics.cfl = 1.0;
  c.numerics.gravity = 0.0;
  c.output.duration = 0.2;
  write(c);
  const std::string soft = "--set material.young_modulus_pa=1.5e5";
  const Outcome alone = one("one", soft), together = several(3, 1, "three", soft);
  ASSERT_EQ(alone.code, 3) << alone.err;
  EXPECT_EQ(together.code, 3) << together.err;
  const auto message = alone.err.substr(alone.err.rfind("unstable at"));
  const std::string first_line = message.substr(0, message.find('\n'));
  const auto found = together.err.find(first_line);
  EXPECT_NE(found, std::string::npos) << together.err;
  EXPECT_EQ(together.err.find(first_line, found + 1), std::string::npos) << "reported twice";
}

TEST_F(MpiRun, AFrameThatCannotBeWrittenEndsAllRanks) {
  Case c = testing::with_frames(testing::rank_cases()[5].c);
  c.output.duration = 5.0;
  write(c);
  // in the middle of the run a file takes the place of the folder of frames; renamed, because a frame may be written at this moment
  const Outcome outcome =
      run_command(fmt::format("{{ (for i in $(seq 600); do [ -e out/frames/00002.h5 ] && break; sleep 0.05; done; "
                              "until true > out/frames; do n=$((n + 1)); mv -T out/frames out/aside_$n; done) 2>/dev/null & "
                              "{} {} run case.toml --out out --threads 1; }}",
                              launcher(3), MPM_APP),
                  folder / "", folder / "");
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  const auto found = outcome.err.find("out/frames");
  EXPECT_NE(found, std::string::npos) << outcome.err;
}

/// Starts a command in a name space of its own, where it may mount file systems without being root.
constexpr const char* own_mounts = "unshare -r -m";
bool may_mount() { return std::system("unshare -r -m mount -t tmpfs tmpfs /mnt 2>/dev/null") == 0; }

/// How often a text is in another.
int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST_F(MpiRun, AFullDiskEndsAllRanksWithOneMessage) {
  if (!may_mount()) GTEST_SKIP() << "no file system can be mounted here (unshare -r -m)";
  const Case c = testing::with_frames(testing::rank_cases()[5].c);
  write(c);
  ASSERT_EQ(one("whole").code, 0);
  std::uintmax_t size = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "whole")) size += entry.is_regular_file() ? entry.file_size() : 0;
  fs::create_directory(folder / "small");
  for (const unsigned eighth : {3U, 5U, 7U}) {
    const Outcome full = run_command(
        fmt::format("{} bash -c 'mount -t tmpfs -o size={} tmpfs small; {}{} run case.toml --out small/run --threads 1; code=$?; "
                    "find small -name \"*.tmp\" >&2; exit $code'",
                    own_mounts, size * eighth / 8, launcher(3), MPM_APP),
        folder / "", folder / "");
    ASSERT_EQ(full.code, 4) << full.err;
    EXPECT_EQ(count(full.err, "No space left on device"), 1) << full.err;
    EXPECT_EQ(count(full.err, ".tmp"), 0) << "temporaries are left: " << full.err;
  }
}

TEST_F(MpiRun, AWriteThatFailsOnAnotherRankThanTheFirstEndsAllWithOneMessageAndLosesNothing) {
  const Case c = testing::with_frames(testing::rank_cases()[5].c);
  write(c);
  ASSERT_EQ(one("whole").code, 0);
  ASSERT_EQ(several(3, 1, "out", fmt::format("--set output.duration_s={}", c.output.duration / 3.0)).code, 0);
  // that rank may write 16 kB of a file; messages go through sockets, because shared memory is a file, too
  const Outcome failed =
      run_command(fmt::format("{} --mca btl tcp,self bash -c '[ $OMPI_COMM_WORLD_RANK = 2 ] && ulimit -f 16; exec {} run "
                              "case.toml --out out --threads 1 --resume'",
                              launcher(3), MPM_APP),
                  folder / "", folder / "");
  EXPECT_EQ(failed.code, 4) << failed.err;
  EXPECT_EQ(count(failed.err, "File too large"), 1) << failed.err;
  EXPECT_EQ(count(failed.err, "rank 2 on "), 1) << failed.err;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path() << " is left";
  const Outcome resumed = several(2, 1, "out", "--resume");
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  expect_same_files("whole", "out");
}

TEST_F(MpiRun, ARankThatDoesNotSeeTheOutputDirectorySaysSo) {
  if (!may_mount()) GTEST_SKIP() << "no file system can be mounted here (unshare -r -m)";
  write(testing::with_frames(testing::rank_cases()[5].c));
  fs::create_directory(folder / "out");
  const Outcome outcome = run_command(
      fmt::format("{}bash -c 'if [ $OMPI_COMM_WORLD_RANK = 1 ]; then exec {} bash -c \"mount -t tmpfs tmpfs out; exec {} run case.toml "
                  "--out out --threads 1\"; else exec {} run case.toml --out out --threads 1; fi'",
                  launcher(3), own_mounts, MPM_APP, MPM_APP),
      folder / "", folder / "");
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_EQ(count(outcome.err, "this process does not see the file"), 1) << outcome.err;
  EXPECT_EQ(count(outcome.err, "rank 1 on "), 1) << outcome.err;
  EXPECT_EQ(count(outcome.err, "a file system that all machines share"), 1) << outcome.err;
}

TEST_F(MpiRun, OtherCommandsSayThatTheyWorkAlone) {
  const Outcome outcome = mpm(launcher(2), "predict --froude 3");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("not available with more than one rank"), std::string::npos) << outcome.err;
}

TEST_F(MpiRun, AWrongCaseIsReportedOnce) {
  write_file(folder / "case.toml", "[numerics]\ncel_size_m = 1\n");
  const Outcome outcome = several(2, 1, "out");
  EXPECT_EQ(outcome.code, 2);
  const auto first = outcome.err.find("cel_size_m");
  EXPECT_NE(first, std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace mpm
