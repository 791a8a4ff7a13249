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

TEST(Utf8, IsThatOfRfc3629) {
  for (const char* character : {"a", "\x7f", "\u00e4", "\u0800", "\ud7ff", "\ue000", "\uffff", "\U00010000", "\U0010ffff"})
    EXPECT_EQ(utf8_length(character), std::string(character).size()) << character;
  // a trailing byte alone; overlong forms; surrogates; above U+10FFFF; cut off
  for (const char* none : {"\x80", "\xc0\x80", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80",
                           "\xe2\x82", "\xf0\x9f\x8f", "\xc3", ""})
    EXPECT_EQ(utf8_length(none), 0u) << none;
  EXPECT_EQ(first_not_utf8("Schätze\nSch\xe4tze"), std::string("Schätze\nSch").size());
  EXPECT_EQ(first_not_utf8("Schätze"), std::string::npos);
  EXPECT_EQ(first_not_utf8(""), std::string::npos);
}

TEST(PlainText, IsUtf8WithoutControlCharacters) {
  EXPECT_EQ(plain_text("Schätze 5 µm \U0001F3D4"), "Schätze 5 µm \U0001F3D4");
  EXPECT_EQ(plain_text("a\tb\r\x1b[31m"), "a b  [31m");
  EXPECT_EQ(plain_text("Sch\xe4tze"), "Sch?tze");  // Latin-1
  EXPECT_EQ(plain_text("\xc3"), "?");              // cut off
  EXPECT_EQ(plain_text("\xff\xc0\x80"), "???");
  EXPECT_EQ(plain_text("\xed\xa0\x80"), "???");  // a surrogate, which no JSON holds
}

TEST(NumberText, HasAtMostTheGivenNumberOfDigits) {
  EXPECT_EQ(number_text(1.0 / 3.0, 3), "0.333");
  EXPECT_EQ(number_text(1234567.0, 3), "1.23e+06");
}

}  // namespace
}  // namespace mpm
