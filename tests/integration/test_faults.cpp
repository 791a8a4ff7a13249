/// The short form of the fault campaign; the long one is `./run faults`.

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "support/command.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr const char* build = " --sanitized";
#else
constexpr const char* build = "";
#endif

TEST(Faults, AreSurvivedWithAMessageAndLoseNoData) {
  if (std::system("/usr/bin/python3 -c 'import h5py, pandas' 2>/dev/null") != 0)
    GTEST_SKIP() << "h5py or pandas is not installed (Debian: python3-h5py, python3-pandas)";
  const testing::TemporaryDirectory dir;
  const testing::Outcome o = testing::run_command(
      "/usr/bin/python3 '" MPM_SOURCE_DIR "/tests/faults.py' --quick --mpm '" MPM_APP "' --out '" + (dir / "tables").string() + "'" + build,
      dir.path(), dir.path());
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  EXPECT_EQ(o.out.find("FAIL"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("data lost in 0"), std::string::npos) << o.out << o.err;
  EXPECT_TRUE(std::filesystem::exists(dir / "tables/faults.md"));
}

TEST(CampaignFaults, AreTheFailureOfOneRunAndLoseNoData) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "limits the address space";
#endif
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0) GTEST_SKIP() << "h5py is not installed (Debian: python3-h5py)";
  const testing::TemporaryDirectory dir;
  const testing::Outcome o =
      testing::run_command("/usr/bin/python3 '" MPM_SOURCE_DIR "/tests/campaign_faults.py' --trials 20 --mpm '" MPM_APP "' --out '" +
                               (dir / "tables").string() + "'",
                           dir.path(), dir.path());
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  EXPECT_NE(o.out.find("data lost in 0"), std::string::npos) << o.out << o.err;
}

}  // namespace
}  // namespace mpm
