#include "libmpm/io/hdf5.hpp"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
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
  Writer w(path);
  put<double>(w, "x", {1, 2, 3, 4, 5, 6}, {2, 3});
  put<std::uint64_t>(w, "id", {0, ~std::uint64_t{0}});
  w.attribute("time_s", 0.1);
  w.attribute("title", std::string("Lawine auf Mast, µ = 0"));
  w.attribute("count", std::int64_t{-7});
  w.commit();
}

#if !defined(__SANITIZE_ADDRESS__)  // which reserves terabytes of addresses
/// With so many bytes to have, calls f. @returns whether it ran out of memory
template <class F>
bool out_of_memory_with(std::size_t bytes, F&& f) {
  ::malloc_trim(0);  // what was freed would do otherwise
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit before{};
  ::getrlimit(RLIMIT_AS, &before);
  rlimit low = before;
  low.rlim_cur = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + bytes;
  ::setrlimit(RLIMIT_AS, &low);
  bool refused = false;
  try {
    f();
  } catch (const std::bad_alloc&) {
    refused = true;
  }
  ::setrlimit(RLIMIT_AS, &before);
  return refused;
}

constexpr std::size_t megabyte = std::size_t{1} << 20;

TEST(Hdf5, ShortMemoryIsBadAllocBeforeTheLibraryMeetsIt) {
  // The HDF5 library frees twice, and crashes, when one of its own allocations fails.
  const TemporaryDirectory dir;
  write_sample(dir / "f.h5");
  EXPECT_TRUE(out_of_memory_with(8 * megabyte, [&] { write_sample(dir / "f.h5"); }));
  Writer begun(dir / "g.h5");
  EXPECT_TRUE(out_of_memory_with(8 * megabyte, [&] { put<double>(begun, "x", {1}); }));
  put<double>(begun, "x", {1});  // as good as ever
  begun.commit();
  EXPECT_EQ(Reader(dir / "g.h5").dataset<double>("x", {1}), std::vector<double>{1.0});
  EXPECT_EQ(Reader(dir / "f.h5").real("time_s"), 0.1);
}

TEST(Hdf5, AFileNeedsNoMemoryForItsArrays) {
  const TemporaryDirectory dir;
  const std::vector<double> values(4 * megabyte, 1.0);  // 32 MB
  EXPECT_FALSE(out_of_memory_with(24 * megabyte, [&] {
    Writer w(dir / "f.h5");
    put<double>(w, "x", values);
    w.declare<double>("y", {2, values.size()});
    ArrayWriter y(w.layout());
    for (const std::size_t i : {0, 1}) y.write<double>("y", i * values.size(), values);
    w.add(y.finish());
    w.commit();
  }));
  EXPECT_EQ(Reader(dir / "f.h5").dataset<double>("x", {any_extent}), values);
}
#endif

TEST(Hdf5, ReadsBackEveryTypeAndAttributeThatWasWritten) {
  const TemporaryDirectory dir;
  {
    Writer w(dir / "f.h5");
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
    w.commit();
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
  EXPECT_EQ(r.rows<std::uint8_t>("u8", {2, 1, 2}, 1, 1), (std::vector<std::uint8_t>{7, 1}));
  EXPECT_EQ(r.rows<double>("f32", {any_extent}, 1, any_extent), (std::vector<double>{2.0}));
  EXPECT_TRUE(r.rows<double>("f64", {2}, 2, 0).empty());
  EXPECT_NE(io_error_of([&] { (void)r.rows<double>("f64", {2}, 1, 2); }).find("has no 2 rows from row 1 on"), std::string::npos);
  EXPECT_EQ(r.real("r"), 1.0 / 3.0);
  EXPECT_EQ(r.text("s"), "µ");
  EXPECT_EQ(r.text("empty"), "");
  EXPECT_EQ(r.integer("i"), -3);
  EXPECT_EQ(r.datasets(), (std::vector<std::string>{"f32", "f64", "i32", "i64", "none", "u64", "u8"}));
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
  Writer w(dir / "g.h5");
  EXPECT_THROW(put<double>(w, "x", {1, 2, 3}, {2, 2}), IoError);
  put<double>(w, "x", {1});
  EXPECT_THROW(put<double>(w, "x", {1}), IoError);
}

TEST(Hdf5, FailureToWriteLeavesTheOldFile) {
  const TemporaryDirectory dir;
  EXPECT_NE(io_error_of([&] { Writer w(dir / "none/f.h5"); }).find("No such file"), std::string::npos);
  const auto write = [&] {
    Writer w(dir / "f.h5");
    for (const char* name : {"x", "y", "z"}) put<double>(w, name, std::vector<double>(8000, 1.0));
    w.attribute("time_s", 0.1);
    w.commit();
  };
  write();
  const std::string old = read_file(dir / "f.h5");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  // The limit replaces the full disk. The library itself reaches it, in the first array, in the third, by the last byte.
  for (const std::size_t limit : {std::size_t{64}, std::size_t{1} << 16, std::size_t{20000 * 8}, old.size() - 1}) {
    rlimit low = before;
    low.rlim_cur = limit;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &low), 0);
    const std::string message = io_error_of(write);
    ::setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_NE(message.find("cannot write '" + (dir / "f.h5").string() + "': File too large; raise"), std::string::npos) << message;
    EXPECT_EQ(read_file(dir / "f.h5"), old);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir.path()), {}), 1) << "no temporary is left";
  }
  std::signal(SIGXFSZ, handler);
}

TEST(Hdf5, PiecesGiveTheBytesOfTheWhole) {
  const TemporaryDirectory dir;
  std::mt19937_64 random(1);
  std::vector<double> x(30000);
  std::vector<std::int32_t> n(7000);
  std::vector<std::uint8_t> few(5);
  for (double& v : x) v = std::ldexp(static_cast<double>(random()), -64);
  for (std::int32_t& v : n) v = static_cast<std::int32_t>(random());
  {
    Writer w(dir / "whole.h5");
    w.attribute("time_s", 0.1);
    put(w, "x", x, {10000, 3});
    put<float>(w, "none", {}, {0, 2});
    put(w, "few", few);
    put(w, "n", n);
    w.commit();
  }
  Writer w(dir / "pieces.h5");
  w.attribute("time_s", 0.1);
  w.declare<double>("x", {10000, 3});
  w.declare<float>("none", {0, 2});
  w.declare<std::uint8_t>("few", {5});
  w.declare<std::int32_t>("n", {7000});
  EXPECT_FALSE(std::filesystem::exists(dir / "pieces.h5"));
  const auto all_x = std::span<const double>(x);
  const auto all_n = std::span<const std::int32_t>(n);
  ArrayWriter one(w.layout()), other(w.layout());
  one.write("n", 0, all_n.first(1));
  for (std::size_t i = 0; i < x.size(); i += 1000) (i % 3000 == 0 ? one : other).write("x", i, all_x.subspan(i, 1000));
  other.write("n", 1, all_n.subspan(1));
  for (const std::size_t i : {4, 2, 3, 0, 1}) one.write<std::uint8_t>("few", i, {&few[i], 1});
  EXPECT_NE(io_error_of([&] { one.write("n", 7000, all_n.first(1)); }).find("'n' is given more values"), std::string::npos);
  EXPECT_NE(io_error_of([&] { one.write("y", 0, all_n.first(1)); }).find("'y' was not declared"), std::string::npos);
  w.add(other.finish());
  w.add(one.finish());
  w.commit();
  EXPECT_EQ(read_file(dir / "pieces.h5"), read_file(dir / "whole.h5"));
  EXPECT_EQ(Reader(dir / "pieces.h5").dataset<double>("x", {10000, 3}), x);
}

TEST(Hdf5, AnArrayThatLacksValuesIsNoFile) {
  const TemporaryDirectory dir;
  Writer w(dir / "f.h5");
  w.declare<double>("x", {2});
  const double one = 1.0;
  ArrayWriter x(w.layout());
  x.write<double>("x", 1, {&one, 1});
  w.add(x.finish());
  EXPECT_NE(io_error_of([&] { w.commit(); }).find("'x' is given fewer values"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(dir / "f.h5"));
}

TEST(Hdf5, AnArrayWhoseValuesTwoProcessesWriteIsNoFile) {
  const TemporaryDirectory dir;
  Writer w(dir / "f.h5");
  w.declare<double>("x", {2});
  const double values[] = {1.0, 2.0};
  ArrayWriter one(w.layout()), other(w.layout());
  one.write<double>("x", 0, values);
  other.write<double>("x", 1, std::span(values).first(1));
  w.add(one.finish());
  w.add(other.finish());
  EXPECT_NE(io_error_of([&] { w.commit(); }).find("'x' is given values twice"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(dir / "f.h5"));
}

TEST(Hdf5, AProcessThatDoesNotSeeTheFileSaysThatItMustBeShared) {
  const TemporaryDirectory dir, elsewhere;
  Writer w(dir / "f.h5");
  w.declare<double>("x", {2});
  Layout layout = w.layout();
  layout.temporary = elsewhere / layout.temporary.filename();  // where another machine would look for it
  const std::string message = io_error_of([&] { ArrayWriter writer(layout); });
  EXPECT_NE(message.find("f.h5': this process does not see the file"), std::string::npos) << message;
  EXPECT_NE(message.find("a file system that all machines share"), std::string::npos) << message;
  EXPECT_TRUE(std::filesystem::is_empty(elsewhere.path())) << "nothing was left there";
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
  Writer w(dir / "g.h5");
  put<double>(w, "x", {1});
  EXPECT_THROW(put<double>(w, "x", {1}), IoError);  // the HDF5 library itself fails here, and would print its error stack
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace mpm::hdf5
