#include <takt/wire/words.hpp>

#include <gtest/gtest.h>

#include <takt/core/words.hpp>

namespace takt::wire::words_test {
namespace {

TEST(CutText, IsUnchangedIfItFits) {
  EXPECT_EQ(cut("", 5), "");
  EXPECT_EQ(cut("12345", 5), "12345");
}

TEST(CutText, EndsWithDotsIfTheyFit) {
  EXPECT_EQ(cut("123456", 5), "12...");
  EXPECT_EQ(cut("123456", 2), "12");
}

TEST(CutText, NeverSplitsACharacter) {
  const std::string text = "a\u00e9\u00e9\u20ac\u20ac\U0001f916 and more that does not fit";
  for (std::size_t bytes = 4; bytes < text.size(); ++bytes) {
    const std::string short_text = cut(text, bytes);
    ASSERT_LE(short_text.size(), bytes);
    for (std::size_t at = 0; at < short_text.size();) {
      const std::size_t length = utf8_length(std::string_view{short_text}.substr(at));
      ASSERT_NE(length, 0U) << bytes << " bytes: " << short_text;
      at += length;
    }
  }
}

TEST(CutText, KeepsInvalidUtf8WithinTheLimit) { EXPECT_LE(cut(std::string(300, '\x80'), 255).size(), 255U); }

TEST(TextField, CutsATextThatIsTooLong) {
  LifecycleStatus status;
  set(status.text(), std::string(1000, 'x'));
  EXPECT_EQ(status.text().to_string(), std::string(252, 'x') + "...");
  set(status.name(), "servo");
  EXPECT_EQ(status.name(), "servo");
}

TEST(Path, ContainsCellDeviceAndModule) {
  EXPECT_EQ(path_of(kNoCell, "robot"), "-/robot");
  EXPECT_EQ(path_of("cell", "robot", "servo"), "cell/robot/servo");
}

TEST(Enumerator, HasATextEvenIfItIsInvalid) {
  EXPECT_STREQ(to_text(STATE_DESTRUCT), "DESTRUCT");
  EXPECT_STREQ(to_text(EVENT_GIVE_UP), "give up");
  EXPECT_STREQ(to_text(ERROR_STALE), "stale");
  EXPECT_STREQ(to_text(ERROR_OVERRUN), "overrun");
  EXPECT_STREQ(to_text(DEVICE_ENDED), "ended");
  EXPECT_STREQ(to_text(DEVICE_ARMED), "armed");
  EXPECT_STREQ(to_text(STAGE_UNDONE), "undone");
  EXPECT_STREQ(to_text(HEALTH_DEGRADED), "degraded");
  EXPECT_STREQ(to_text(COMMAND_TAP), "tap");
  EXPECT_STREQ(to_text(COMMAND_LOG), "log");
  EXPECT_STREQ(to_text(COMMAND_TRACE), "trace");
  EXPECT_STREQ(to_text(COMMAND_SWAP), "swap");
  EXPECT_STREQ(to_text(COMMAND_CHANGE), "change");
  EXPECT_STREQ(to_text(COMMAND_PUT_BACK), "put back");
  EXPECT_STREQ(to_text(static_cast<LifecycleState>(99)), "?");
}

}  // namespace
}  // namespace takt::wire::words_test
