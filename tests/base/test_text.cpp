#include "libmpm/base/text.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace mpm {
namespace {

TEST(Counted, TheNounHasTheNumberOfTheCount) {
  EXPECT_EQ(counted(0, "run"), "0 runs");
  EXPECT_EQ(counted(1, "run"), "1 run");
  EXPECT_EQ(counted(2, "run"), "2 runs");
  EXPECT_EQ(counted(std::uint64_t{1}, "particle"), "1 particle");
  EXPECT_EQ(counted(std::size_t{1234567}, "row"), "1234567 rows");
}

TEST(PlainText, IsUtf8WithoutControlCharacters) {
  EXPECT_EQ(plain_text("Schätze 5 µm \U0001F3D4"), "Schätze 5 µm \U0001F3D4");
  EXPECT_EQ(plain_text("a\tb\r\x1b[31m"), "a b  [31m");
  EXPECT_EQ(plain_text("Sch\xe4tze"), "Sch?tze");  // Latin-1
  EXPECT_EQ(plain_text("\xc3"), "?");              // cut off
  EXPECT_EQ(plain_text("\xff\xc0\x80"), "???");
}

TEST(NumberText, HasAtMostTheGivenNumberOfDigits) {
  EXPECT_EQ(number_text(1.0 / 3.0, 3), "0.333");
  EXPECT_EQ(number_text(1234567.0, 3), "1.23e+06");
}

}  // namespace
}  // namespace mpm
