#include <takt/core/bounded_string.hpp>

#include <sstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace takt::bounded_string_test {
namespace {

using Short = BoundedString<4>;

TEST(BoundedString, IsEmptyAtFirst) {
  const Short text;
  EXPECT_EQ(text.size(), 0U);
  EXPECT_STREQ(text.c_str(), "");
  EXPECT_EQ(Short{static_cast<const char*>(nullptr)}, "");
}

TEST(BoundedString, HoldsAsManyBytesAsItsBound) {
  EXPECT_EQ(Short{"abc"}.size(), 3U);
  EXPECT_EQ(Short{"abcd"}, "abcd");
  EXPECT_EQ(Short{"abcde"}, "abcd");  // longer text is cut off
  EXPECT_EQ((Short{"abcdef", 3}), "abc");
  EXPECT_EQ(Short::max_size, 4U);
}

TEST(BoundedString, IsAssignedFromEveryKindOfText) {
  Short text{"abcd"};
  text = "ab";
  EXPECT_EQ(text, "ab");
  text = std::string{"cd"};
  EXPECT_EQ(text, std::string{"cd"});
  text = std::string_view{"xyz"};
  EXPECT_EQ(text, std::string_view{"xyz"});
  text = BoundedString<8>{"longer text"};
  EXPECT_EQ(text, BoundedString<8>{"long"});
  text.assign("a\0b", 3);
  EXPECT_EQ(text.size(), 3U);
  EXPECT_STREQ(text.c_str(), "a");
  text = text.c_str() + 1;  // assigns a part of the text to the text itself
  EXPECT_EQ(text, "");
  text = {};
  EXPECT_EQ(text.size(), 0U);
}

TEST(BoundedString, ComparesTheWholeText) {
  const Short text{"abcd"};
  EXPECT_TRUE(text == Short{"abcd"} && "abcd" == text && std::string{"abcd"} == text);
  EXPECT_TRUE(text != Short{"abc"} && text != "abcde" && text != std::string{"abcde"});
  EXPECT_NE(text, BoundedString<8>{"abcde"});
}

TEST(BoundedString, ConvertsToEveryKindOfText) {
  const Short text{"abc"};
  const char* pointer = text;
  EXPECT_STREQ(pointer, "abc");
  EXPECT_EQ(text.to_string(), "abc");
  EXPECT_EQ(text.view(), "abc");
  std::ostringstream stream;
  stream << text;
  EXPECT_EQ(stream.str(), "abc");
}

}  // namespace
}  // namespace takt::bounded_string_test
