#include <takt/wire/notices.hpp>

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace notices_test {
namespace {

using namespace takt::wire;
using namespace std::chrono_literals;
using testing::ElementsAre;

struct Recorder {
  std::vector<std::string> texts;
  Notices notices{[this](const std::string& text) { texts.push_back(text); }};
  Notices::Clock::time_point now = Notices::Clock::time_point{} + 1h;
  void tell(const std::string& text) { notices.tell(text, now); }
};

TEST(Notices, AreReportedOnlyOnce) {
  Recorder recorder;
  for (int i = 0; i < 100; ++i) recorder.tell("a");
  recorder.tell("b");
  EXPECT_THAT(recorder.texts, ElementsAre("a", "b"));
}

TEST(Notices, AreLimitedToTenPerMinute) {
  Recorder recorder;
  for (int i = 0; i < 25; ++i) recorder.tell(std::to_string(i));
  EXPECT_EQ(recorder.texts.size(), 10U);
  recorder.now += 61s;
  recorder.tell("later");
  ASSERT_EQ(recorder.texts.size(), 12U);
  EXPECT_EQ(recorder.texts[10], "15 more rejections in the last minute");
  EXPECT_EQ(recorder.texts[11], "later");
}

TEST(Notices, CanBeReportedWithoutAListener) {
  Notices notices{nullptr};
  notices.tell("a");
}

}  // namespace
}  // namespace notices_test
