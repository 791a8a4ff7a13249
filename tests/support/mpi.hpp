#pragma once
/// Common parts of tests with real ranks.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace mpm::testing {

#ifdef MPM_MPI
inline constexpr bool with_mpi = true;
#else
inline constexpr bool with_mpi = false;
#endif

/// Skipped, with the reason, in a build without MPI.
class MpiTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!with_mpi) GTEST_SKIP() << "built without MPI; `./run build mpi` and `ctest --preset mpi -R Mpi` run this";
  }
};

/// Ranks yield the processor while they wait for messages, because several tests run on the same cores.
inline const char* const patient = "--mca mpi_yield_when_idle 1 --mca btl_vader_single_copy_mechanism none";
inline std::string launcher(int ranks) {
  return fmt::format("mpirun --allow-run-as-root --oversubscribe --bind-to none {} -np {} ", patient, ranks);
}

}  // namespace mpm::testing
