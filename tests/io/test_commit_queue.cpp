#include "libmpm/io/commit_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "support/io_error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;
using testing::io_error_of;
using testing::TemporaryDirectory;

std::unique_ptr<AtomicFile> complete_file(const std::filesystem::path& path, const std::string& content) {
  auto file = std::make_unique<AtomicFile>(path);
  file->write(content);
  return file;
}

std::size_t temporaries_in(const std::filesystem::path& directory) {
  return static_cast<std::size_t>(std::ranges::count_if(std::filesystem::directory_iterator(directory),
                                                        [](const auto& entry) { return entry.path().extension() == ".tmp"; }));
}

TEST(CommitQueue, GivesFilesTheirNamesInTheOrderInWhichTheyCome) {
  const TemporaryDirectory dir;
  CommitQueue commits;
  for (int i = 0; i < 20; ++i) commits.add(complete_file(dir / "f", std::to_string(i)));
  commits.wait();
  EXPECT_EQ(read_file(dir / "f"), "19");
  EXPECT_EQ(temporaries_in(dir.path()), 0U);
}

TEST(CommitQueue, EndsWithAllFilesComplete) {
  const TemporaryDirectory dir;
  {
    CommitQueue commits;
    for (const char* name : {"a", "b", "c"}) commits.add(complete_file(dir / name, name));
  }
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(read_file(dir / name), name);
}

TEST(CommitQueue, HoldsFewOpenFiles) {
  const TemporaryDirectory dir;
  CommitQueue commits;
  for (int i = 0; i < 50; ++i) {
    commits.add(complete_file(dir / std::to_string(i), "x"));
    EXPECT_LE(temporaries_in(dir.path()), CommitQueue::most);
  }
}

TEST(CommitQueue, ReportsAnErrorAndRemovesTheFilesThatFollow) {
  const TemporaryDirectory dir;
  std::filesystem::create_directories(dir / "taken");  // a file cannot get the name of a directory
  CommitQueue commits;
  commits.add(complete_file(dir / "before", "x"));
  const std::string message = io_error_of([&] {
    commits.add(complete_file(dir / "taken", "x"));
    commits.add(complete_file(dir / "after", "x"));
    commits.wait();
  });
  EXPECT_THAT(message, HasSubstr("taken"));
  EXPECT_EQ(io_error_of([&] { commits.add(complete_file(dir / "later", "x")); }), message);
  EXPECT_TRUE(std::filesystem::exists(dir / "before"));
  EXPECT_FALSE(std::filesystem::exists(dir / "after") || std::filesystem::exists(dir / "later"));
  EXPECT_EQ(temporaries_in(dir.path()), 0U);
}

TEST(CommitQueue, WithoutAFileNothingHappens) {
  CommitQueue commits;
  commits.add(nullptr);
  commits.wait();
}

}  // namespace
}  // namespace mpm
