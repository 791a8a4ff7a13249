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

TEST(Table, ReadsBehindAByteOrderMark) {
  const TemporaryDirectory dir;
  write_file(dir / "t.csv", "\xEF\xBB\xBFtime_s,x_m\n0,1.5\n");
  EXPECT_EQ(Table::read(dir / "t.csv").columns(), (Columns{"time_s", "x_m"}));
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
  write_file(path, "a,b\n1,2\n3,Sch\xe4tze\n");  // Latin-1
  EXPECT_NE(error_of_reading(path).find(file + ":3: a character is not UTF-8"), std::string::npos) << error_of_reading(path);
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
  SeriesWriter series(dir / "s.csv", 2, "time_s,x_m\n");
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(Table::read(dir / "s.csv").rows(), static_cast<std::size_t>(i));
    series.append(std::vector<double>{0.1 * i, 1.0 * i});
  }
  EXPECT_EQ(read_file(dir / "s.csv"), "time_s,x_m\n0,0\n0.1,1\n0.2,2\n");
  EXPECT_THROW(series.append(std::vector<double>{1.0}), IoError);
}

TEST(SeriesWriter, GoesOnAfterTheRowsItIsGiven) {
  const TemporaryDirectory dir;
  const Columns columns = {"time_s", "x_m"};
  const std::vector<std::vector<double>> values{{0.0, 0.1}, {1.0, std::sin(1.0)}};
  write_table(dir / "table.csv", columns, values);
  write_file(dir / "s.csv", "what a killed run left");
  SeriesWriter series(dir / "s.csv", 2, table_text(columns, values));
  EXPECT_EQ(read_file(dir / "s.csv"), read_file(dir / "table.csv"));
  series.append(std::vector<double>{0.2, 3.0});
  EXPECT_EQ(read_file(dir / "s.csv"), read_file(dir / "table.csv") + "0.2,3\n");
}

TEST(SeriesWriter, TellsWhenItsFileIsNotThereAnyMore) {
  const TemporaryDirectory dir;
  const std::vector<double> row{1.0};
  make_directory(dir / "run");
  SeriesWriter deleted(dir / "run/s.csv", 1, "time_s\n");
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
