#include "libmpm/io/json.hpp"

#include <gtest/gtest.h>

namespace mpm {
namespace {

TEST(Checksums, AreThoseOfZip) {
  EXPECT_EQ(checksum(""), "00000000");
  EXPECT_EQ(checksum("123456789"), "cbf43926");  // the check value of CRC-32
}

TEST(Checksums, OfAJsonTextTellEveryChange) {
  const std::string json = with_checksum("{\n  \"series_crc32\": \"12345678\",\n  \"crc32\": \"00000000\",\n  \"force_n\": 5.0\n}\n");
  EXPECT_TRUE(is_intact(json));
  EXPECT_EQ(json.find("\"00000000\""), std::string::npos);
  for (std::size_t i = 0; i < json.size(); ++i) {
    std::string altered = json;
    altered[i] = '9';
    if (altered == json) continue;
    EXPECT_FALSE(is_intact(altered)) << altered;
  }
  EXPECT_FALSE(is_intact(json.substr(0, json.size() - 1)));
  EXPECT_TRUE(is_intact("{\"force_n\": 5.0}")) << "without a checksum nothing is known";
}

}  // namespace
}  // namespace mpm
