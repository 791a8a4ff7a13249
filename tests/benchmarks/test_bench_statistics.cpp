/// The regression tracker's verdicts on synthetic measurements of a busy machine (tests/support/check_bench_statistics.py).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "libmpm/io/atomic_file.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::TemporaryDirectory;

class TrackerStatistics : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (std::system("/usr/bin/python3 -c 'import numpy' >/dev/null 2>&1") != 0)
      GTEST_SKIP() << "NumPy is not installed (Debian: python3-numpy)";
    const TemporaryDirectory dir;
    const std::string output = (dir / "counts.json").string();
    const std::string line =
        fmt::format("/usr/bin/python3 '{0}/tests/support/check_bench_statistics.py' '{0}/python' '{1}'", MPM_SOURCE_DIR, output);
    ASSERT_EQ(std::system(line.c_str()), 0) << line;
    counts = nlohmann::json::parse(read_file(output));
  }
  static int count(const char* ratio, const char* what) { return counts[ratio][what].get<int>(); }
  static inline nlohmann::json counts;  // by true ratio: of 100 runs
};

// Of 100 runs. A change of 5 % lies 3 % above the threshold, six standard errors of 0.5 %: that a run misses it needs an unlucky set of
// launches.
constexpr int nearly_all = 95;

TEST_F(TrackerStatistics, TellsASlowdownOfFivePerCent) {
  EXPECT_GE(count("1.05", "slower"), nearly_all);
  EXPECT_EQ(count("1.05", "faster"), 0);
}

TEST_F(TrackerStatistics, TellsASpeedUpOfFivePerCent) {
  EXPECT_GE(count("0.95", "faster"), nearly_all);
  EXPECT_EQ(count("0.95", "slower"), 0);
}

TEST_F(TrackerStatistics, StaysQuietOnNoChange) { EXPECT_EQ(count("1.00", "no change"), 100); }

TEST_F(TrackerStatistics, CoversTheTruthAsOftenAsItSays) {
  for (const char* ratio : {"0.95", "1.00", "1.05"}) EXPECT_GE(count(ratio, "covered"), nearly_all) << ratio;  // 99 are expected
}

}  // namespace
}  // namespace mpm
