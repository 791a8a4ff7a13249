#include "run_control.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace mpm::app {
namespace {

constexpr double day = 86400.0, year = 365.25 * day;

TEST(ClockText, ShowsMinutesAndHours) {
  EXPECT_EQ(clock_text(0.0), "0:00");
  EXPECT_EQ(clock_text(754.4), "12:34");
  EXPECT_EQ(clock_text(5025.0), "1:23:45");
  EXPECT_EQ(clock_text(3.0 * day), "72:00:00");
}

TEST(ClockText, ShowsDaysAndYearsOfLongEstimates) {
  EXPECT_EQ(clock_text(4.0 * day), "4 days");
  EXPECT_EQ(clock_text(400.0 * day), "400 days");
  EXPECT_EQ(clock_text(2.0 * year), "2 years");
}

TEST(ClockText, StaysShortForAbsurdEstimates) {
  EXPECT_EQ(clock_text(1314199600000.0 * 3600.0), "1.5e+08 years");
  EXPECT_EQ(clock_text(1e300), "3.17e+292 years");  // no integer overflows
  EXPECT_EQ(clock_text(std::numeric_limits<double>::infinity()), "unknown time");
  EXPECT_EQ(clock_text(std::numeric_limits<double>::quiet_NaN()), "unknown time");
}

}  // namespace
}  // namespace mpm::app
