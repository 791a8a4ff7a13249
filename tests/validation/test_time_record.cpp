#include "validation/harness/time_record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "libmpm/base/error.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm::validation {
namespace {

const TimeRecord kinked{{0.0, 1.0, 1.0, 3.0}, {0.0, 2.0, 4.0, 0.0}};  // two values at 1 s, as digitised records have

TEST(TimeRecord, IsLinearBetweenItsPointsAndConstantBeyondThem) {
  EXPECT_EQ(kinked.at(-1.0), 0.0);
  EXPECT_DOUBLE_EQ(kinked.at(0.25), 0.5);
  EXPECT_DOUBLE_EQ(kinked.at(2.0), 2.0);
  EXPECT_EQ(kinked.at(5.0), 0.0);
}

TEST(TimeRecord, MeanIsTheIntegralOverTheTime) {
  EXPECT_DOUBLE_EQ(kinked.mean(0.0, 3.0), (1.0 + 4.0) / 3.0);
  EXPECT_DOUBLE_EQ(kinked.mean(0.5, 1.0), 1.5);  // ends between points and on one
  EXPECT_DOUBLE_EQ(kinked.mean(1.5, 2.0), 2.5);  // between two points
  EXPECT_DOUBLE_EQ(kinked.mean(2.0, 5.0), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(kinked.mean(0.0, 0.5) * 0.5 + kinked.mean(0.5, 2.5) * 2.0, kinked.mean(0.0, 2.5) * 2.5);
}

TEST(TimeRecord, FirstRiseThroughALevel) {
  EXPECT_DOUBLE_EQ(kinked.first_above(1.0), 0.5);
  EXPECT_DOUBLE_EQ(kinked.first_above(3.0), 1.0);
  EXPECT_EQ((TimeRecord{{2.0, 3.0}, {5.0, 6.0}}.first_above(1.0)), 2.0);  // it begins above
  EXPECT_TRUE(std::isinf(kinked.first_above(4.1)));
}

TEST(TimeRecord, RowsOfOneQuantityAreReadInTheOrderOfTime) {
  const auto file = std::filesystem::path(testing::TempDir()) / "time_record.csv";
  write_file(file, "# two gauges\nquantity,time_s,value\na,2,20\nb,1,7\na,1,10\na,3,30\n");
  const TimeRecord a = read_record(file, "a");
  EXPECT_EQ(a.time, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_EQ(a.value, (std::vector<double>{10.0, 20.0, 30.0}));
  EXPECT_THROW(read_record(file, "c"), IoError);
}

}  // namespace
}  // namespace mpm::validation
