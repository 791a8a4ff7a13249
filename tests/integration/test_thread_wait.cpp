/// How the threads of `mpm` wait: a short spin, unless the user has chosen otherwise.

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>
#include <thread>

#include "libmpm/driver/threads.hpp"
#include "support/command.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// GOMP_SPINCOUNT as the OpenMP runtime of `mpm` shows it, after all settings have been made.
std::string spin_count(const std::string& environment) {
  const testing::TemporaryDirectory directory;
  const testing::Outcome o =
      testing::run_command("env -u OMP_WAIT_POLICY -u GOMP_SPINCOUNT OMP_DISPLAY_ENV=verbose " + environment + " '" MPM_APP "' --version",
                           directory.path(), directory.path());
  EXPECT_EQ(o.code, 0) << o.err;
  const std::string name = "GOMP_SPINCOUNT = '";
  const auto start = o.err.rfind(name);  // the last: of the program that goes on
  if (start == std::string::npos) return o.err;
  const auto from = start + name.size();
  return o.err.substr(from, o.err.find('\'', from) - from);
}

TEST(ThreadWait, IsAShortSpinWhereTheUserChoseNothing) { EXPECT_EQ(spin_count(""), short_spin); }

TEST(ThreadWait, IsTheUsersWhereTheUserChose) {
  EXPECT_EQ(spin_count("GOMP_SPINCOUNT=7"), "7");
  EXPECT_EQ(spin_count("OMP_WAIT_POLICY=passive"), "0");
  EXPECT_GT(std::stoull(spin_count("OMP_WAIT_POLICY=active")), 1'000'000u);
}

TEST(ThreadBinding, LeavesEachThreadAProcessorOfItsOwn) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "needs two processors";
  const testing::TemporaryDirectory directory;
  const testing::Outcome o = testing::run_command(
      "env -u GOMP_SPINCOUNT -u OMP_WAIT_POLICY OMP_PROC_BIND=true OMP_DISPLAY_AFFINITY=true OMP_AFFINITY_FORMAT='on %A.' '" MPM_APP
      "' run '" MPM_SOURCE_DIR
      "/examples/avalanche_fr3.toml' --set numerics.cell_size_m=0.875 --set output.duration_s=0.01 --threads 2 --out out",
      directory.path(), directory.path());
  EXPECT_EQ(o.code, 0) << o.err;
  std::set<std::string> places;
  const std::regex line("on (\\S+)\\.");
  for (std::sregex_iterator match(o.err.begin(), o.err.end(), line), end; match != end; ++match) places.insert((*match)[1]);
  EXPECT_GE(places.size(), 2U) << o.err;
}

}  // namespace
}  // namespace mpm
