#include "libmpm/io/atomic_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <string>

#include "support/io_error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::io_error_of;
using testing::TemporaryDirectory;

std::ptrdiff_t files_in(const std::filesystem::path& directory) {
  return std::distance(std::filesystem::directory_iterator(directory), std::filesystem::directory_iterator());
}

TEST(AtomicFile, HoldsWhatWasWrittenAndNothingElseIsLeft) {
  const TemporaryDirectory dir;
  const std::string content("a\0b\n", 4);
  write_file(dir / "f", content);
  EXPECT_EQ(read_file(dir / "f"), content);
  write_file(dir / "f", "");
  EXPECT_EQ(read_file(dir / "f"), "");
  EXPECT_EQ(files_in(dir.path()), 1);
}

TEST(AtomicFile, KeepsTheOldContentUntilCommitAndWithoutIt) {
  const TemporaryDirectory dir;
  write_file(dir / "f", "old");
  {
    AtomicFile file(dir / "f");
    file.write("new");
    EXPECT_EQ(read_file(dir / "f"), "old");
  }
  EXPECT_EQ(read_file(dir / "f"), "old");
  EXPECT_EQ(files_in(dir.path()), 1);
}

TEST(AtomicFile, TwoWritersOfOneFileDoNotMix) {
  const TemporaryDirectory dir;
  AtomicFile a(dir / "f"), b(dir / "f");
  a.write("aaaa");
  b.write("bb");
  a.commit();
  EXPECT_EQ(read_file(dir / "f"), "aaaa");
  b.commit();
  EXPECT_EQ(read_file(dir / "f"), "bb");
}

TEST(AtomicFile, FollowsNoLinkAtTheNameOfItsTemporary) {
  const TemporaryDirectory dir;
  write_file(dir / "victim", "precious");
  for (int i = 0; i < 1000; ++i)  // the names are predictable
    std::filesystem::create_symlink(dir / "victim", dir / (".f." + std::to_string(::getpid()) + "." + std::to_string(i) + ".tmp"));
  write_file(dir / "f", "content");
  EXPECT_EQ(read_file(dir / "victim"), "precious");
  EXPECT_EQ(read_file(dir / "f"), "content");
}

TEST(ReadFile, IsBounded) {
  const TemporaryDirectory dir;
  write_file(dir / "f", "1234");
  EXPECT_EQ(read_file(dir / "f", 4), "1234");
  EXPECT_NE(io_error_of([&] { (void)read_file(dir / "f", 3); }).find("more than 3 bytes"), std::string::npos);
  EXPECT_NE(io_error_of([] { (void)read_file("/dev/zero", 1 << 20); }), "");
}

TEST(AtomicFile, MissingDirectoryIsNamedWithReasonAndRemedy) {
  const TemporaryDirectory dir;
  const std::string message = io_error_of([&] { write_file(dir / "none/f", "x"); });
  EXPECT_NE(message.find((dir / "none/f").string()), std::string::npos) << message;
  EXPECT_NE(message.find("No such file or directory"), std::string::npos) << message;
  EXPECT_NE(message.find("check the path"), std::string::npos) << message;
}

TEST(AtomicFile, TargetThatIsADirectoryFailsAndLeavesNoTemporary) {
  const TemporaryDirectory dir;
  make_directory(dir / "f");
  EXPECT_THROW(write_file(dir / "f", "x"), IoError);
  EXPECT_EQ(files_in(dir.path()), 1);
}

TEST(AtomicFile, ReadOnlyDirectoryFails) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryDirectory dir;
  std::filesystem::permissions(dir.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const std::string message = io_error_of([&] { write_file(dir / "f", "x"); });
  EXPECT_NE(message.find("permissions"), std::string::npos) << message;
}

TEST(AtomicFile, FullDiskLeavesTheOldFileAndNoTemporary) {
  // A limit on the size of files replaces the full disk: write() fails in the same way, part of the content is out already.
  const TemporaryDirectory dir;
  write_file(dir / "f", "old");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit low = before;
  low.rlim_cur = 1 << 16;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &low), 0);
  const std::string message = io_error_of([&] { write_file(dir / "f", std::string(1 << 20, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find((dir / "f").string()), std::string::npos) << message;
  EXPECT_NE(message.find("File too large"), std::string::npos) << message;
  EXPECT_EQ(read_file(dir / "f"), "old");
  EXPECT_EQ(files_in(dir.path()), 1);
}

TEST(AtomicFile, KeepsTheFileOfBeforeUnderAnotherName) {
  const TemporaryDirectory dir;
  const auto write_new = [&](std::string_view content) {
    AtomicFile file(dir / "f");
    file.write(content);
    file.commit(dir / "before");
  };
  write_new("1");
  EXPECT_FALSE(std::filesystem::exists(dir / "before"));
  write_new("2");
  EXPECT_EQ(read_file(dir / "before"), "1");
  write_new("3");
  EXPECT_EQ(read_file(dir / "before"), "2");
  EXPECT_EQ(read_file(dir / "f"), "3");
  EXPECT_EQ(files_in(dir.path()), 2);
}

TEST(RemoveLeftovers, OfTheDeadOnly) {
  const TemporaryDirectory dir;
  const pid_t child = ::fork();
  if (child == 0) {  // is killed while it writes
    AtomicFile file(dir / "f.h5");
    file.write("half of ");
    ::_exit(0);
  }
  ASSERT_GT(child, 0);
  siginfo_t ended;
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT), 0);  // ended, and its number is still taken
  const std::string of_another =
      ".f.h5." + std::to_string(::getppid()) + ".0.tmp";  // left by one whose number was given to another process
  for (const std::string& name : {of_another, std::string(".f.tmp"), std::string("f.h5.1.0.tmp"), std::string(".mine.x.0.tmp")})
    write_file(dir / name, "left or not ours");
  AtomicFile being_written(dir / "g.h5");
  ASSERT_EQ(files_in(dir.path()), 6);
  remove_leftovers(dir.path());
  EXPECT_EQ(files_in(dir.path()), 4);
  EXPECT_FALSE(std::filesystem::exists(dir / of_another));
  being_written.write("whole");
  being_written.commit();
  EXPECT_EQ(read_file(dir / "g.h5"), "whole");
  remove_leftovers(dir / "none");
  ::waitpid(child, nullptr, 0);
}

TEST(MakeDirectory, MakesParentsAndRefusesAFileOfThatName) {
  const TemporaryDirectory dir;
  make_directory(dir / "a/b/c");
  make_directory(dir / "a/b/c");
  EXPECT_TRUE(std::filesystem::is_directory(dir / "a/b/c"));
  write_file(dir / "f", "x");
  EXPECT_THROW(make_directory(dir / "f"), IoError);
  EXPECT_THROW(make_directory(dir / "f/g"), IoError);
}

TEST(ReadFile, MissingFileAndDirectoryFail) {
  const TemporaryDirectory dir;
  EXPECT_THROW((void)read_file(dir / "none"), IoError);
  EXPECT_THROW((void)read_file(dir.path()), IoError);
}

}  // namespace
}  // namespace mpm
