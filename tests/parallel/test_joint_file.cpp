#include "libmpm/io/joint_file.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <new>
#include <numeric>

#include "libmpm/base/error.hpp"
#include "libmpm/core/state.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "support/temporary_directory.hpp"
#include "support/thread_ranks.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryDirectory;

constexpr std::size_t values_of_a_rank = 1000;

/// An array to which every rank gives its share. @param disturb  called on every rank before it writes
void write_together(const fs::path& path, Ranks& ranks, const std::function<void(int rank)>& disturb = {}) {
  const int rank = ranks.rank();
  JointFile file(ranks);
  Message about;
  if (rank == 0) put(about, 7);
  file.begin(
      [&] {
        auto made = std::make_unique<hdf5::Writer>(path);
        made->attribute("kind", std::string("test"));
        made->declare<double>("x", {3 * values_of_a_rank});
        return made;
      },
      about);
  EXPECT_EQ(MessageReader(about).get<int>(), 7);
  file.attempt([&](hdf5::ArrayWriter& out) {
    if (disturb) disturb(rank);
    for (int part = 0; part < 3; ++part) {
      if (ranks.size() > 1 && part != rank) continue;
      const std::size_t first = static_cast<std::size_t>(part) * values_of_a_rank;
      std::vector<double> values(values_of_a_rank);
      std::iota(values.begin(), values.end(), static_cast<double>(first));
      out.write<double>("x", first, values);
    }
  });
  file.commit();
}

/// On three ranks. @returns the message with which the first ends; the others must not throw
std::string failure(const fs::path& path, const std::function<void(int rank)>& disturb) {
  std::string message;
  testing::on_ranks(3, [&](Transport& transport) {
    BlockExchange exchange(transport);
    try {
      write_together(path, exchange, disturb);
    } catch (const IoError& error) {
      EXPECT_TRUE(exchange.first());
      message = error.what();
    }
    EXPECT_FALSE(exchange.busy());
  });
  return message;
}

bool empty(const TemporaryDirectory& directory) { return fs::is_empty(directory.path()); }

TEST(JointFile, HasTheBytesThatOneRankWrites) {
  const TemporaryDirectory directory;
  write_together(directory / "one.h5", one_rank());
  EXPECT_EQ(failure(directory / "three.h5", {}), "");
  EXPECT_EQ(read_file(directory / "three.h5"), read_file(directory / "one.h5"));
  EXPECT_EQ(hdf5::Reader(directory / "three.h5").dataset<double>("x", {3 * values_of_a_rank}).back(), 2999.0);
}

TEST(JointFile, AnErrorOfAnyRankIsReportedOnceOnTheFirstAndNothingIsLeft) {
  for (int victim = 0; victim < 3; ++victim) {
    const TemporaryDirectory directory;
    const std::string message = failure(directory / "f.h5", [&](int rank) {
      if (rank == victim) throw file_error("cannot write", directory / "f.h5", ENOSPC);
    });
    EXPECT_NE(message.find("No space left on device; free space"), std::string::npos) << message;
    EXPECT_EQ(message.starts_with("rank " + std::to_string(victim) + " on "), victim > 0) << message;
    EXPECT_TRUE(empty(directory)) << "rank " << victim;
  }
}

TEST(JointFile, OfSeveralErrorsThatOfTheFirstRankInOrderIsReported) {
  const TemporaryDirectory directory;
  const std::string message = failure(directory / "f.h5", [&](int rank) {
    if (rank > 0) throw IoError("this is rank " + std::to_string(rank));
  });
  EXPECT_NE(message.find("this is rank 1"), std::string::npos) << message;
}

TEST(JointFile, AFileThatTheFirstRankCannotBeginEndsAll) {
  const TemporaryDirectory directory;
  std::atomic<int> writers = 0;
  const std::string message = failure(directory / "missing" / "f.h5", [&](int) { ++writers; });
  EXPECT_NE(message.find("the directory does not exist"), std::string::npos) << message;
  EXPECT_EQ(writers, 0) << "without a file nobody writes";
}

TEST(JointFile, AShortMemoryOfAnotherRankIsReported) {
  const TemporaryDirectory directory;
  std::string message;
  testing::on_ranks(2, [&](Transport& transport) {
    BlockExchange exchange(transport);
    const FirstError error = [&] {
      FirstError e;
      e.attempt([&] {
        if (!exchange.first()) throw std::bad_alloc();
      });
      return e;
    }();
    try {
      EXPECT_FALSE(agree_on_errors(error, exchange));
      EXPECT_FALSE(exchange.first());
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::internal);
      message = e.what();
    }
  });
  EXPECT_NE(message.find("rank 1 on "), std::string::npos);
  EXPECT_NE(message.find("out of memory"), std::string::npos);
}

}  // namespace
}  // namespace mpm
