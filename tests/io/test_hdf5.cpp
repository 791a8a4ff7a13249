#include "libmpm/io/hdf5.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <new>
#include <random>
#include <string>
#include <thread>

#include "libmpm/io/atomic_file.hpp"
#include "support/io_error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm::hdf5 {
namespace {

using mpm::testing::io_error_of;
using mpm::testing::TemporaryDirectory;

template <class T>
void put(Writer& w, const std::string& name, const std::vector<T>& v, const Shape& shape = {}) {
  w.dataset(name, std::span<const T>(v), shape);
}

void write_sample(const std::filesystem::path& path) {
  Writer w;
  put<double>(w, "x", {1, 2, 3, 4, 5, 6}, {2, 3});
  put<std::uint64_t>(w, "id", {0, ~std::uint64_t{0}});
  w.attribute("time_s", 0.1);
  w.attribute("title", std::string("Lawine auf Mast, µ = 0"));
  w.attribute("count", std::int64_t{-7});
  w.save(path);
}

#if !defined(__SANITIZE_ADDRESS__)  // which reserves terabytes of addresses
TEST(Hdf5, ShortMemoryIsBadAllocBeforeTheLibraryMeetsIt) {
  // The HDF5 library frees twice, and crashes, when one of its own allocations fails.
  const TemporaryDirectory dir;
  constexpr std::size_t megabyte = std::size_t{1} << 20;
  const std::vector<double> values(8 * megabyte, 1.0);  // 64 MB
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  rlimit low = before;
  low.rlim_cur =
      pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + 80 * megabyte;  // for the array once, not for a file that moves
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &low), 0);
  bool refused = false;
  {
    Writer w;
    try {
      put<double>(w, "x", values);
      w.save(dir / "f.h5");
    } catch (const std::bad_alloc&) {
      refused = true;
    } catch (const IoError&) {
    }
  }
  ::setrlimit(RLIMIT_AS, &before);
  EXPECT_TRUE(refused);
  Writer again;  // as good as ever
  put<double>(again, "x", values);
  again.save(dir / "f.h5");
  EXPECT_EQ(Reader(dir / "f.h5").dataset<double>("x", {any_extent}), values);
}
#endif

TEST(Hdf5, ReadsBackEveryTypeAndAttributeThatWasWritten) {
  const TemporaryDirectory dir;
  {
    Writer w;
    put<double>(w, "f64", {0.1, -1e300});
    put<float>(w, "f32", {0.1F, 2.0F});
    put<std::uint64_t>(w, "u64", {0, ~std::uint64_t{0}});
    put<std::int64_t>(w, "i64", {-1, INT64_MAX});
    put<std::int32_t>(w, "i32", {INT32_MIN, 5});
    put<std::uint8_t>(w, "u8", {0, 255, 7, 1}, {2, 1, 2});
    put<double>(w, "none", {}, {0, 3});
    w.attribute("r", 1.0 / 3.0);
    w.attribute("s", std::string("µ"));
    w.attribute("empty", std::string());
    w.attribute("i", std::int64_t{-3});
    w.save(dir / "f.h5");
  }
  const Reader r(dir / "f.h5");
  EXPECT_EQ(r.dataset<double>("f64", {2}), (std::vector<double>{0.1, -1e300}));
  EXPECT_EQ(r.dataset<float>("f32", {2}), (std::vector<float>{0.1F, 2.0F}));
  EXPECT_EQ(r.dataset<double>("f32", {2}), (std::vector<double>{double{0.1F}, 2.0}));
  EXPECT_EQ(r.dataset<std::uint64_t>("u64", {any_extent}), (std::vector<std::uint64_t>{0, ~std::uint64_t{0}}));
  EXPECT_EQ(r.dataset<std::int64_t>("i64", {2}), (std::vector<std::int64_t>{-1, INT64_MAX}));
  EXPECT_EQ(r.dataset<std::int32_t>("i32", {2}), (std::vector<std::int32_t>{INT32_MIN, 5}));
  EXPECT_EQ(r.dataset<std::uint8_t>("u8", {2, 1, 2}), (std::vector<std::uint8_t>{0, 255, 7, 1}));
  EXPECT_EQ(r.shape("u8"), (Shape{2, 1, 2}));
  EXPECT_TRUE(r.dataset<double>("none", {0, 3}).empty());
  EXPECT_EQ(r.real("r"), 1.0 / 3.0);
  EXPECT_EQ(r.text("s"), "µ");
  EXPECT_EQ(r.text("empty"), "");
  EXPECT_EQ(r.integer("i"), -3);
  EXPECT_TRUE(r.has_dataset("u8"));
  EXPECT_FALSE(r.has_dataset("v8"));
}

TEST(Hdf5, EqualContentGivesEqualBytes) {
  const TemporaryDirectory dir;
  write_sample(dir / "a.h5");
  write_sample(dir / "b.h5");
  EXPECT_EQ(read_file(dir / "a.h5"), read_file(dir / "b.h5"));
}

TEST(Hdf5, ThreadsWriteAndReadAtOnceWhereTheLibraryIsBuiltForIt) {
  if (!usable_by_threads()) GTEST_SKIP() << "this HDF5 library is for one thread only";
  const TemporaryDirectory dir;
  write_sample(dir / "alone.h5");
  const auto work = [&](const std::string& name) {
    for (int i = 0; i < 50; ++i) {
      write_sample(dir / name);
      EXPECT_EQ(Reader(dir / name).real("time_s"), 0.1);
      EXPECT_NE(io_error_of([&] { (void)Reader(dir / name).real("none"); }).find("no attribute 'none'"), std::string::npos);
    }
  };
  std::thread other(work, "a.h5");
  work("b.h5");
  other.join();
  EXPECT_EQ(read_file(dir / "a.h5"), read_file(dir / "alone.h5"));
  EXPECT_EQ(read_file(dir / "b.h5"), read_file(dir / "alone.h5"));
}

TEST(Hdf5, WrongRequestsAreErrorsThatNameTheFileAndTheItem) {
  const TemporaryDirectory dir;
  write_sample(dir / "f.h5");
  const Reader r(dir / "f.h5");
  const auto error = [&](auto call) { return io_error_of(call); };
  EXPECT_NE(error([&] { (void)r.dataset<double>("y", {2}); }).find("no dataset 'y'"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.dataset<double>("x", {2, 2}); }).find("shape (2, 3), (2, 2) was expected"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.dataset<double>("x", {6}); }).find((dir / "f.h5").string()), std::string::npos);
  EXPECT_NE(error([&] { (void)r.dataset<float>("x", {2, 3}); }).find("another type"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.dataset<std::int64_t>("id", {2}); }).find("another type"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.dataset<double>("id", {2}); }).find("another type"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.real("title"); }).find("'title'"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.text("count"); }).find("'count'"), std::string::npos);
  EXPECT_NE(error([&] { (void)r.integer("none"); }).find("no attribute 'none'"), std::string::npos);
  Writer w;
  EXPECT_THROW(put<double>(w, "x", {1, 2, 3}, {2, 2}), IoError);
  put<double>(w, "x", {1});
  EXPECT_THROW(put<double>(w, "x", {1}), IoError);
}

TEST(Hdf5, FailureToWriteLeavesTheOldFile) {
  const TemporaryDirectory dir;
  Writer w;
  put<double>(w, "x", {1});
  EXPECT_NE(io_error_of([&] { w.save(dir / "none/f.h5"); }).find("No such file"), std::string::npos);
  w.save(dir / "f.h5");  // the content is still there
  EXPECT_EQ(Reader(dir / "f.h5").dataset<double>("x", {1}), std::vector<double>{1.0});
}

/// Without fsync, which takes most of the time of many small files.
void write_quickly(const std::filesystem::path& path, const std::string& content) { std::ofstream(path, std::ios::binary) << content; }

TEST(Hdf5, EveryTruncationIsAnError) {
  const TemporaryDirectory dir;
  write_sample(dir / "f.h5");
  const std::string whole = read_file(dir / "f.h5");
  for (std::size_t n = 0; n < whole.size(); n += n < 64 ? 1 : 97) {
    write_quickly(dir / "cut.h5", whole.substr(0, n));
    EXPECT_THROW(Reader(dir / "cut.h5"), IoError) << n << " bytes";
  }
}

TEST(Hdf5, EveryAlterationIsAnError) {
  // CRC-32 detects every change within 32 adjacent bits; elsewhere it misses one in 2^32.
  const TemporaryDirectory dir;
  write_sample(dir / "f.h5");
  const std::string whole = read_file(dir / "f.h5");
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    std::string altered = whole;
    altered[random() % altered.size()] ^= static_cast<char>(1 + random() % 255);
    write_quickly(dir / "altered.h5", altered);
    EXPECT_THROW(Reader(dir / "altered.h5"), IoError) << i;
  }
}

TEST(Hdf5, FilesOfOtherProgramsAreRefused) {
  const TemporaryDirectory dir;
  write_file(dir / "t.h5", "This is no HDF5 file, although its name says so.");
  EXPECT_NE(io_error_of([&] { Reader r(dir / "t.h5"); }).find("another program"), std::string::npos);
  EXPECT_NE(io_error_of([&] { Reader r(dir / "none.h5"); }).find("does not exist"), std::string::npos);
}

TEST(Hdf5, NothingIsPrintedWhenARequestFails) {
  const TemporaryDirectory dir;
  write_sample(dir / "f.h5");
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const Reader r(dir / "f.h5");
  EXPECT_THROW((void)r.dataset<double>("y", {1}), IoError);
  EXPECT_THROW((void)r.real("title"), IoError);
  Writer w;
  put<double>(w, "x", {1});
  EXPECT_THROW(put<double>(w, "x", {1}), IoError);  // the HDF5 library itself fails here, and would print its error stack
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace mpm::hdf5
