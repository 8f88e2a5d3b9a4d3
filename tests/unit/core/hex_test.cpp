#include <takt/core/hex.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace takt::hex_test {
namespace {

TEST(Hex, SurvivesARoundTrip) {
  std::vector<std::byte> all;
  for (unsigned byte = 0; byte <= std::numeric_limits<unsigned char>::max(); ++byte)
    all.push_back(std::byte(byte));
  const std::string text = in_hex(all);
  EXPECT_EQ(text.size(), 512U);
  EXPECT_EQ(text.substr(0, 6), "000102");
  EXPECT_EQ(text.substr(506), "fdfeff");
  EXPECT_EQ(bytes_of_hex(text), all);
  EXPECT_EQ(bytes_of_hex("FD")->front(), std::byte{0xfd});
  EXPECT_TRUE(bytes_of_hex("")->empty());
}

TEST(Hex, MustBeAnEvenNumberOfHexDigits) {
  for (const char* text : {"0", "0g", "g0", "000", " 0", "0x", "-1", "00 0", "0\n"})
    EXPECT_FALSE(bytes_of_hex(text).has_value()) << text;
}

}  // namespace
}  // namespace takt::hex_test
