#include <takt/os/keyboard.hpp>

#include <gmock/gmock.h>

namespace takt::os::keyboard_test {
namespace {

using testing::ElementsAre;

std::vector<int> keys_of(std::string typed, bool whole = false) {
  std::vector<int> keys;
  while (const auto key = take_key(typed, whole)) keys.push_back(*key);
  return keys;
}

TEST(Keyboard, ReturnsKeysOneByOne) {
  EXPECT_THAT(keys_of(""), ElementsAre());
  EXPECT_THAT(keys_of("ab\r"), ElementsAre('a', 'b', '\r'));
  EXPECT_THAT(keys_of("\033[Aq\033[B\033OA"),
              ElementsAre(Keyboard::kUp, 'q', Keyboard::kDown, Keyboard::kUp));
  EXPECT_THAT(keys_of("\033[5~\033[6~\033[H\033[F\033[1~\033[4~\033OH"),
              ElementsAre(Keyboard::kPageUp, Keyboard::kPageDown, Keyboard::kHome, Keyboard::kEnd,
                          Keyboard::kHome, Keyboard::kEnd, Keyboard::kHome));
  EXPECT_THAT(keys_of("\b\x7f"), ElementsAre(Keyboard::kBackspace, Keyboard::kBackspace));
}

TEST(Keyboard, ReturnsEachByteOfAUtf8Character) { EXPECT_THAT(keys_of("ö"), ElementsAre(0xc3, 0xb6)); }

TEST(Keyboard, SkipsUnknownKeys) { EXPECT_THAT(keys_of("\033[15~\033[1;5C\033OPq"), ElementsAre('q')); }

TEST(Keyboard, TreatsEscapeAsAKeyOnlyIfNoSequenceFollows) {
  std::string typed = "\033";
  EXPECT_EQ(take_key(typed, false), std::nullopt);
  EXPECT_EQ(typed, "\033");
  EXPECT_EQ(take_key(typed, true), Keyboard::kEscape);
  EXPECT_EQ(take_key(typed, true), std::nullopt);
  EXPECT_THAT(keys_of("\033q"), ElementsAre(Keyboard::kEscape, 'q'));
}

TEST(Keyboard, WaitsForTheRestOfAnEscapeSequence) {
  std::string typed = "\033[";
  EXPECT_EQ(take_key(typed, false), std::nullopt);
  typed += "1;5";
  EXPECT_EQ(take_key(typed, false), std::nullopt);
  typed += "A";
  EXPECT_EQ(take_key(typed, false), Keyboard::kUp);
}

}  // namespace
}  // namespace takt::os::keyboard_test
