#include <takt/dds/notices.hpp>

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace notices_test {
namespace {

using namespace takt::dds;
using namespace std::chrono_literals;
using testing::ElementsAre;

struct Told {
  std::vector<std::string> texts;
  Notices notices{[this](const std::string& text) { texts.push_back(text); }};
  Notices::Clock::time_point now = Notices::Clock::time_point{} + 1h;
  void tell(const std::string& text) { notices.tell(text, now); }
};

TEST(Notices, AreToldOnce) {
  Told told;
  for (int i = 0; i < 100; ++i) told.tell("a");
  told.tell("b");
  EXPECT_THAT(told.texts, ElementsAre("a", "b"));
}

TEST(Notices, AreTenInAMinuteAndTheRestIsCounted) {
  Told told;
  for (int i = 0; i < 25; ++i) told.tell(std::to_string(i));
  EXPECT_EQ(told.texts.size(), 10U);
  told.now += 61s;
  told.tell("later");
  ASSERT_EQ(told.texts.size(), 12U);
  EXPECT_EQ(told.texts[10], "15 more were refused in the last minute");
  EXPECT_EQ(told.texts[11], "later");
}

TEST(Notices, NobodyHasToListen) {
  Notices notices{nullptr};
  notices.tell("a");
}

}  // namespace
}  // namespace notices_test
