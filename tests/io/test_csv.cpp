#include "libmpm/io/csv.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "libmpm/io/atomic_file.hpp"
#include "support/io_error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::TemporaryDirectory;
using Columns = std::vector<std::string>;

std::string error_of_reading(const std::filesystem::path& path, const std::string& column = {}) {
  try {
    const Table t = Table::read(path);
    if (!column.empty()) (void)t.numbers(column);
  } catch (const IoError& e) {
    return e.what();
  }
  return {};
}

TEST(Table, EveryDoubleReadsBackToTheSameBits) {
  const TemporaryDirectory dir;
  std::mt19937_64 random(7);
  std::vector<double> values = {0.0,
                                -0.0,
                                0.1,
                                1.0 / 3.0,
                                1e-300,
                                5e-324,
                                std::numeric_limits<double>::max(),
                                std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};
  while (values.size() < 2000) {
    const std::uint64_t bits = random();
    double v = 0;
    std::memcpy(&v, &bits, sizeof v);
    if (!std::isnan(v)) values.push_back(v);
  }
  const Columns names = {"a_m", "b_s"};
  std::vector<std::vector<double>> columns = {values, std::vector<double>(values.rbegin(), values.rend())};
  write_table(dir / "t.csv", names, columns);
  const Table t = Table::read(dir / "t.csv");
  EXPECT_EQ(t.columns(), names);
  for (std::size_t c = 0; c < 2; ++c) {
    const std::vector<double> read = t.numbers(names[c]);
    ASSERT_EQ(read.size(), values.size());
    EXPECT_EQ(std::memcmp(read.data(), columns[c].data(), read.size() * sizeof(double)), 0);
  }
}

TEST(Table, NumbersAreWrittenWithTheFewestDigits) {
  EXPECT_EQ(format_number(0.1), "0.1");
  EXPECT_EQ(format_number(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(format_number(-std::nan("")), "nan");
}

TEST(Table, ReadsCommentsQuotesEmptyCellsAndForeignLineEnds) {
  const TemporaryDirectory dir;
  write_file(dir / "t.csv", "# where it comes from, with a comma\n\nname, x_m ,y_m\r\n\"a, \"\"b\"\"\",1.5,\r\n# in between\nc,+2,nan");
  const Table t = Table::read(dir / "t.csv");
  EXPECT_EQ(t.columns(), (Columns{"name", "x_m", "y_m"}));
  EXPECT_EQ(t.text("name"), (Columns{"a, \"b\"", "c"}));
  EXPECT_EQ(t.numbers("x_m"), (std::vector<double>{1.5, 2.0}));
  EXPECT_TRUE(std::isnan(t.numbers("y_m")[0]));
  EXPECT_TRUE(std::isnan(t.numbers("y_m")[1]));
}

TEST(Table, FaultsNameFileLineValueAndColumn) {
  const TemporaryDirectory dir;
  const std::filesystem::path path = dir / "t.csv";
  const std::string file = path.string();
  write_file(path, "# comment\na,b\n1,2\n3\n");
  EXPECT_NE(error_of_reading(path).find(file + ":4: 1 cell where"), std::string::npos) << error_of_reading(path);
  write_file(path, "a,b\n1,2\n3,4m\n");
  EXPECT_NE(error_of_reading(path, "b").find(file + ":3: column 'b' holds '4m'"), std::string::npos) << error_of_reading(path, "b");
  EXPECT_NE(error_of_reading(path, "c").find("no column 'c'; there are: a, b"), std::string::npos);
  write_file(path, "a,\"b\n");
  EXPECT_NE(error_of_reading(path).find(file + ":1: a double quote"), std::string::npos);
  write_file(path, "a,a\n");
  EXPECT_NE(error_of_reading(path).find("'a' is named twice"), std::string::npos);
  write_file(path, "# only a comment\n");
  EXPECT_NE(error_of_reading(path).find("no header"), std::string::npos);
  EXPECT_NE(error_of_reading(dir / "none.csv").find("does not exist"), std::string::npos);
}

TEST(SeriesWriter, EveryRowIsInTheFileWhenAppendReturns) {
  const TemporaryDirectory dir;
  SeriesWriter series(dir / "s.csv", {"time_s", "x_m"});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(Table::read(dir / "s.csv").rows(), static_cast<std::size_t>(i));
    series.append(std::vector<double>{0.1 * i, 1.0 * i});
  }
  EXPECT_EQ(read_file(dir / "s.csv"), "time_s,x_m\n0,0\n0.1,1\n0.2,2\n");
  EXPECT_THROW(series.append(std::vector<double>{1.0}), IoError);
}

TEST(SeriesWriter, ResumedSeriesEqualsOneThatWasNeverStopped) {
  const TemporaryDirectory dir;
  const auto row = [](int i) { return std::vector<double>{0.1 * i, std::sin(i)}; };
  const Columns columns = {"time_s", "x_m"};
  {
    SeriesWriter whole(dir / "whole.csv", columns);
    for (int i = 0; i < 20; ++i) whole.append(row(i));
  }
  // Killed after row 12, in the middle of the next one; the checkpoint is of row 7.
  std::string torn;
  {
    SeriesWriter s(dir / "s.csv", columns);
    for (int i = 0; i < 13; ++i) s.append(row(i));
    torn = read_file(dir / "s.csv") + "1.3,0.4";
  }
  write_file(dir / "s.csv", torn);
  {
    SeriesWriter s = SeriesWriter::resume(dir / "s.csv", columns, 8, row(7)[0]);
    for (int i = 8; i < 20; ++i) s.append(row(i));
  }
  EXPECT_EQ(read_file(dir / "s.csv"), read_file(dir / "whole.csv"));
}

TEST(SeriesWriter, ResumeMakesUpNoRowsThatAreGone) {
  const TemporaryDirectory dir;
  const std::vector<std::string> columns{"time_s", "x_m"};
  const auto refusal = [&](std::string_view content, std::size_t rows, double time) {
    write_file(dir / "s.csv", content);
    const std::string message = testing::io_error_of([&] { (void)SeriesWriter::resume(dir / "s.csv", columns, rows, time); });
    EXPECT_EQ(read_file(dir / "s.csv"), content);  // left as it was
    EXPECT_NE(message.find((dir / "s.csv").string()), std::string::npos) << message;
    return message;
  };
  EXPECT_THROW((void)SeriesWriter::resume(dir / "none.csv", columns, 1, 0.0), IoError);
  EXPECT_FALSE(std::filesystem::exists(dir / "none.csv"));
  EXPECT_NE(refusal("time_s,x_m\n0,1\n", 2, 1.0).find("holds 1 row, 2 are needed"), std::string::npos);
  EXPECT_NE(refusal("time_s,x_m\n0,1\n1,2", 2, 1.0).find("holds 1 row,"), std::string::npos);  // torn inside the second
  EXPECT_NE(refusal("", 1, 0.0).find("holds 0 rows"), std::string::npos);
  EXPECT_NE(refusal("time_s,y_m\n0,1\n", 1, 0.0).find("time_s,y_m"), std::string::npos);
  EXPECT_NE(refusal("time_s,x_m\n0,1\n3,2\n", 2, 1.0).find(":3: the row is of t = 3 s"), std::string::npos);
  EXPECT_NE(refusal("time_s,x_m\n0\n1,2\n", 2, 1.0).find(":2: the row is damaged"), std::string::npos);
  EXPECT_NE(refusal(std::string_view("time_s,x_m\n0,\0\0\n1,2\n", 20), 2, 1.0).find(":2: the row is damaged"), std::string::npos);
  // What comes after the rows that stay may be anything, such as the zeros of a power cut.
  write_file(dir / "s.csv", std::string_view("time_s,x_m\n0,1\n1,2\n\0\0\0\0\n", 24));
  { SeriesWriter s = SeriesWriter::resume(dir / "s.csv", columns, 2, 1.0); }
  EXPECT_EQ(read_file(dir / "s.csv"), "time_s,x_m\n0,1\n1,2\n");
}

TEST(SeriesWriter, TellsWhenItsFileIsNotThereAnyMore) {
  const TemporaryDirectory dir;
  const std::vector<double> row{1.0};
  make_directory(dir / "run");
  SeriesWriter deleted(dir / "run/s.csv", {"time_s"});
  deleted.append(row);
  std::filesystem::rename(dir / "run", dir / "moved");
  EXPECT_NE(testing::io_error_of([&] { deleted.append(row); }).find("deleted, moved or replaced"), std::string::npos);
  make_directory(dir / "run");
  write_file(dir / "run/s.csv", "another");
  EXPECT_THROW(deleted.append(row), IoError);
  EXPECT_THROW(deleted.sync(), IoError);
  std::filesystem::remove_all(dir / "run");
  EXPECT_THROW(deleted.sync(), IoError);
}

TEST(Table, TornLastLineIsDroppedOnlyWhenAskedFor) {
  const TemporaryDirectory dir;
  write_file(dir / "t.csv", "a\n1\n2");
  EXPECT_EQ(Table::read(dir / "t.csv").rows(), 2u);
  EXPECT_EQ(Table::read(dir / "t.csv", Table::LastLine::may_be_torn).rows(), 1u);
}

}  // namespace
}  // namespace mpm
