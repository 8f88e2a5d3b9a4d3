#include <watch/view.hpp>

#include <gmock/gmock.h>

#include <takt/os/keyboard.hpp>

namespace takt::tool::watch::watch_view_test {
namespace {

using Keyboard = os::Keyboard;

/// A user who looks at a list of `rows` rows, ten of which are visible at once.
struct Person {
  View view{};
  Shown shown{};

  explicit Person(int rows) {
    for (int i = 0; i < rows; ++i) shown.targets.push_back("robot.m" + std::to_string(i));
    shown.room = 10;
    settle(view, shown);
  }
  Done press(int key) {
    const Done done = watch::press(view, key, shown);
    settle(view, shown);
    return done;
  }
  void type(const std::string& text) {
    for (const char c : text) press(static_cast<unsigned char>(c));
  }
};

TEST(WatchView, KeepsTheSelectionWithinTheList) {
  Person person{30};
  EXPECT_EQ(person.view.chosen, "robot.m0");
  person.press(Keyboard::kUp);
  EXPECT_EQ(person.view.chosen, "robot.m0");
  person.press(Keyboard::kDown);
  EXPECT_EQ(person.view.chosen, "robot.m1");
  person.press(Keyboard::kEnd);
  EXPECT_EQ(person.view.chosen, "robot.m29");
  EXPECT_EQ(person.view.first, 20U);
  person.press(Keyboard::kDown);
  EXPECT_EQ(person.view.chosen, "robot.m29");
  person.press(Keyboard::kPageUp);
  EXPECT_EQ(person.view.chosen, "robot.m20");
  EXPECT_EQ(person.view.first, 20U) << "the list scrolls only if it must";
  person.press(Keyboard::kPageUp);
  EXPECT_EQ(person.view.chosen, "robot.m11");
  EXPECT_EQ(person.view.first, 11U);
  person.press(Keyboard::kHome);
  EXPECT_EQ(person.view.chosen, "robot.m0");
  person.press(Keyboard::kPageDown);
  EXPECT_EQ(person.view.chosen, "robot.m9");
}

TEST(WatchView, IgnoresKeysInAnEmptyList) {
  Person person{0};
  for (const int key :
       {Keyboard::kUp, Keyboard::kDown, Keyboard::kEnd, Keyboard::kPageDown, int{'\r'}, int{'s'}, int{'D'}}) {
    EXPECT_FALSE(person.press(key).command);
    EXPECT_EQ(person.view.chosen, "");
    EXPECT_EQ(person.view.page, Page::list);
    EXPECT_FALSE(person.view.asked);
  }
}

TEST(WatchView, KeepsTheSelectionOnItsRowWhenRowsMove) {
  Person person{30};
  person.press(Keyboard::kDown);
  std::reverse(person.shown.targets.begin(), person.shown.targets.end());
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m1");
  EXPECT_EQ(person.view.chosen_at, 28U);
  EXPECT_EQ(person.view.first, 19U);
}

// takt watch discovers devices one by one. The device that it discovers first is rarely the first one in the
// list, so the selection moves to the first row until the user presses a key.
TEST(WatchView, SelectsTheFirstRowUntilAKeyIsPressed) {
  Person person{3};
  person.shown.targets.insert(person.shown.targets.begin(), "line");
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "line");
  person.press(Keyboard::kDown);
  person.shown.targets.insert(person.shown.targets.begin(), "arm");
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m0");
}

TEST(WatchView, SelectsTheRowThatReplacesALostOne) {
  Person person{3};
  person.press(Keyboard::kEnd);
  person.shown.targets.pop_back();
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m1");
}

TEST(WatchView, AsksForConfirmationIfTheSelectionMovedByItself) {
  Person person{3};
  person.press(Keyboard::kDown);
  const auto lose_a_row = [&person] {
    person.shown.targets.erase(person.shown.targets.begin() + 1);
    settle(person.view, person.shown);
  };
  lose_a_row();
  ASSERT_EQ(person.view.chosen, "robot.m2");
  EXPECT_FALSE(person.press('r').command);
  EXPECT_EQ(person.view.asked, (Command{Verb::recover, "robot.m2"}));
  EXPECT_FALSE(person.press('r').command) << "repeating the key does not confirm";
  person.press(Keyboard::kUp);
  EXPECT_EQ(person.press('r').command, (Command{Verb::recover, "robot.m0"})) << "the user selected this row";
}

TEST(WatchView, CanSelectBothRowsWithTheSameName) {
  Person person{3};
  person.shown.targets = {"robot", "robot", "line"};
  person.press(Keyboard::kDown);
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen_at, 1U);
  person.press(Keyboard::kDown);
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "line");
}

TEST(WatchView, HasAKeyForEachCommand) {
  Person person{3};
  person.press(Keyboard::kDown);
  const std::pair<char, Verb> keys[] = {{'i', Verb::initialize}, {'r', Verb::recover}};
  for (const auto& [key, verb] : keys)
    EXPECT_EQ(person.press(key).command, (Command{verb, "robot.m1"})) << key;
  person.press('\r');
  EXPECT_EQ(person.press('r').command, (Command{Verb::recover, "robot.m1"})) << "also on the details page";
  person.press('?');
  EXPECT_FALSE(person.press('r').command) << "not on a page without modules";
}

TEST(WatchView, AsksForConfirmationBeforeAModuleBeginsOrEnds) {
  Person person{3};
  const std::pair<char, Verb> keys[] = {
      {'s', Verb::start}, {'t', Verb::stop}, {'x', Verb::reset}, {'R', Verb::restart}, {'D', Verb::destruct}};
  for (const auto& [key, verb] : keys) {
    EXPECT_FALSE(person.press(key).command) << key;
    EXPECT_EQ(person.view.asked, (Command{verb, "robot.m0"}));
    EXPECT_EQ(person.press('y').command, (Command{verb, "robot.m0"})) << key;
  }
  EXPECT_FALSE(person.press('D').command);
  EXPECT_EQ(person.view.asked, (Command{Verb::destruct, "robot.m0"}));
  EXPECT_FALSE(person.press('\r').command);
  EXPECT_FALSE(person.view.asked);
  EXPECT_EQ(person.view.page, Page::list) << "the key that cancels does nothing else";
  EXPECT_EQ(person.view.message, "destruct of robot.m0 cancelled");
  person.press('D');
  EXPECT_EQ(person.press('y').command, (Command{Verb::destruct, "robot.m0"}));
  EXPECT_FALSE(person.press('y').command);
}

TEST(WatchView, RestartsOnlyOneModuleAtATime) {
  Person person{3};
  person.shown.targets[0] = "robot";
  person.press(Keyboard::kHome);
  person.press('R');
  EXPECT_FALSE(person.view.asked);
  EXPECT_EQ(person.view.message, "select a module to restart it");
}

TEST(WatchView, SendsAConfirmedCommandToItsOriginalTarget) {
  Person person{3};
  person.press('D');
  person.shown.targets.erase(person.shown.targets.begin());
  settle(person.view, person.shown);
  EXPECT_EQ(person.press('y').command, (Command{Verb::destruct, "robot.m0"}));
}

TEST(WatchView, TreatsKeysAsTextWhileAFilterIsTyped) {
  Person person{3};
  person.press('/');
  person.type("stq x");
  EXPECT_EQ(person.view.filter, "stq x");
  person.press(Keyboard::kBackspace);
  person.press(Keyboard::kUp);
  EXPECT_EQ(person.view.filter, "stq ");
  person.press('\r');
  EXPECT_FALSE(person.view.typing);
  EXPECT_EQ(person.view.filter, "stq ");
  EXPECT_EQ(person.view.page, Page::list);
  person.press(Keyboard::kEscape);
  EXPECT_EQ(person.view.filter, "");
  person.type("/a");
  person.press(Keyboard::kEscape);
  EXPECT_EQ(person.view.filter, "");
  EXPECT_FALSE(person.view.typing);
}

TEST(WatchView, RemovesAWholeCharacterOnBackspace) {
  Person person{1};
  person.type("/aö€");
  EXPECT_EQ(person.view.filter, "aö€");
  person.press(Keyboard::kBackspace);
  EXPECT_EQ(person.view.filter, "aö");
  person.press(Keyboard::kBackspace);
  EXPECT_EQ(person.view.filter, "a");
  person.press(Keyboard::kBackspace);
  person.press(Keyboard::kBackspace);
  EXPECT_EQ(person.view.filter, "");
}

TEST(WatchView, CyclesThroughTheSortColumns) {
  Person person{3};
  person.press('<');
  EXPECT_EQ(person.view.column, Column::missed);
  person.press('>');
  EXPECT_EQ(person.view.column, Column::name);
  person.press('v');
  EXPECT_TRUE(person.view.reversed);
  person.press('>');
  EXPECT_EQ(person.view.column, Column::state);
  EXPECT_FALSE(person.view.reversed);
}

TEST(WatchView, StepsToTheDetailsOfTheNextOrPreviousRow) {
  Person person{3};
  person.press('\r');
  EXPECT_EQ(person.view.page, Page::details);
  person.press('n');
  EXPECT_EQ(person.view.chosen, "robot.m1");
  person.press('p');
  person.press('p');
  EXPECT_EQ(person.view.chosen, "robot.m0");
  person.press(Keyboard::kEscape);
  EXPECT_EQ(person.view.page, Page::list);
}

TEST(WatchView, KeepsTheDetailsOfAModuleThatIsGone) {
  Person person{3};
  person.press('\r');
  person.shown.targets.erase(person.shown.targets.begin());
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m0");
}

TEST(WatchView, ScrollsALongPageToItsEnd) {
  Person person{3};
  person.shown.length = 12;
  person.press('?');
  person.press(Keyboard::kDown);
  EXPECT_EQ(person.view.scroll, 1U);
  person.press(Keyboard::kEnd);
  EXPECT_EQ(person.view.scroll, 2U);
  person.press(Keyboard::kUp);
  EXPECT_EQ(person.view.scroll, 1U);
  EXPECT_EQ(person.view.chosen, "robot.m0");
}

TEST(WatchView, QuitsFromEveryPage) {
  for (const char key : {'?', 'c', '\r'}) {
    Person person{3};
    person.press(key);
    EXPECT_NE(person.view.page, Page::list);
    EXPECT_TRUE(person.press('q').quit);
  }
}

}  // namespace
}  // namespace takt::tool::watch::watch_view_test
