#include <watch/view.hpp>

#include <gmock/gmock.h>

#include <takt/os/keyboard.hpp>

namespace takt::tool::watch::watch_view_test {
namespace {

using Keyboard = os::Keyboard;

/// Somebody at the keyboard, before a list of `rows` of which ten are seen at once.
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

TEST(WatchView, ArrowsStayWithinTheList) {
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
  EXPECT_EQ(person.view.first, 20U) << "what is seen stays where it is as long as it can";
  person.press(Keyboard::kPageUp);
  EXPECT_EQ(person.view.chosen, "robot.m11");
  EXPECT_EQ(person.view.first, 11U);
  person.press(Keyboard::kHome);
  EXPECT_EQ(person.view.chosen, "robot.m0");
  person.press(Keyboard::kPageDown);
  EXPECT_EQ(person.view.chosen, "robot.m9");
}

TEST(WatchView, AListWithoutRowsHasNothingToChoose) {
  Person person{0};
  for (const int key :
       {Keyboard::kUp, Keyboard::kDown, Keyboard::kEnd, Keyboard::kPageDown, int{'\r'}, int{'s'}, int{'D'}}) {
    EXPECT_FALSE(person.press(key).order);
    EXPECT_EQ(person.view.chosen, "");
    EXPECT_EQ(person.view.place, Place::list);
    EXPECT_FALSE(person.view.asked);
  }
}

TEST(WatchView, TheChosenRowIsFollowedWhereItGoes) {
  Person person{30};
  person.press(Keyboard::kDown);
  std::reverse(person.shown.targets.begin(), person.shown.targets.end());
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m1");
  EXPECT_EQ(person.view.chosen_at, 28U);
  EXPECT_EQ(person.view.first, 19U);
}

// Devices are found one by one, and the first that is found is seldom the first of the list.
TEST(WatchView, UntilAKeyIsPressedTheFirstRowIsChosen) {
  Person person{3};
  person.shown.targets.insert(person.shown.targets.begin(), "line");
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "line");
  person.press(Keyboard::kDown);
  person.shown.targets.insert(person.shown.targets.begin(), "arm");
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m0");
}

TEST(WatchView, WhatHasThePlaceOfARowThatIsGoneIsChosen) {
  Person person{3};
  person.press(Keyboard::kEnd);
  person.shown.targets.pop_back();
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m1");
}

TEST(WatchView, AnOrderToARowThatNobodyChoseIsConfirmed) {
  Person person{3};
  person.press(Keyboard::kDown);
  const auto lose_a_row = [&person] {
    person.shown.targets.erase(person.shown.targets.begin() + 1);
    settle(person.view, person.shown);
  };
  lose_a_row();
  ASSERT_EQ(person.view.chosen, "robot.m2");
  EXPECT_FALSE(person.press('t').order);
  EXPECT_EQ(person.view.asked, (Order{Verb::stop, "robot.m2"}));
  EXPECT_FALSE(person.press('t').order) << "impatience is no consent";
  person.press(Keyboard::kUp);
  EXPECT_EQ(person.press('t').order, (Order{Verb::stop, "robot.m0"})) << "somebody chose this one";
}

TEST(WatchView, TwoRowsOfOneNameAreBothReached) {
  Person person{3};
  person.shown.targets = {"robot", "robot", "line"};
  person.press(Keyboard::kDown);
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen_at, 1U);
  person.press(Keyboard::kDown);
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "line");
}

TEST(WatchView, EachVerbHasAKey) {
  Person person{3};
  person.press(Keyboard::kDown);
  const std::pair<char, Verb> keys[] = {{'i', Verb::initialize},
                                        {'s', Verb::start},
                                        {'t', Verb::stop},
                                        {'r', Verb::recover},
                                        {'x', Verb::reset}};
  for (const auto& [key, verb] : keys) EXPECT_EQ(person.press(key).order, (Order{verb, "robot.m1"})) << key;
  person.press('\r');
  EXPECT_EQ(person.press('t').order, (Order{Verb::stop, "robot.m1"})) << "in the details too";
  person.press('?');
  EXPECT_FALSE(person.press('t').order) << "not where no module is shown";
}

TEST(WatchView, DestructIsDoneOnlyWhenItIsConfirmed) {
  Person person{3};
  EXPECT_FALSE(person.press('D').order);
  EXPECT_EQ(person.view.asked, (Order{Verb::destruct, "robot.m0"}));
  EXPECT_FALSE(person.press('\r').order);
  EXPECT_FALSE(person.view.asked);
  EXPECT_EQ(person.view.place, Place::list) << "the key that says no does nothing else";
  EXPECT_EQ(person.view.message, "no destruct of robot.m0");
  person.press('D');
  EXPECT_EQ(person.press('y').order, (Order{Verb::destruct, "robot.m0"}));
  EXPECT_FALSE(person.press('y').order);
}

TEST(WatchView, WhatIsConfirmedIsWhatWasAskedForThoughTheListHasMovedOn) {
  Person person{3};
  person.press('D');
  person.shown.targets.erase(person.shown.targets.begin());
  settle(person.view, person.shown);
  EXPECT_EQ(person.press('y').order, (Order{Verb::destruct, "robot.m0"}));
}

TEST(WatchView, WhatIsTypedIntoTheFilterIsNoKey) {
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
  EXPECT_EQ(person.view.place, Place::list);
  person.press(Keyboard::kEscape);
  EXPECT_EQ(person.view.filter, "");
  person.type("/a");
  person.press(Keyboard::kEscape);
  EXPECT_EQ(person.view.filter, "");
  EXPECT_FALSE(person.view.typing);
}

TEST(WatchView, BackspaceTakesAWholeCharacterOff) {
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

TEST(WatchView, SortsByTheNeighbourRoundAndRound) {
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

TEST(WatchView, FromTheDetailsOnToTheNextAndBack) {
  Person person{3};
  person.press('\r');
  EXPECT_EQ(person.view.place, Place::details);
  person.press('n');
  EXPECT_EQ(person.view.chosen, "robot.m1");
  person.press('p');
  person.press('p');
  EXPECT_EQ(person.view.chosen, "robot.m0");
  person.press(Keyboard::kEscape);
  EXPECT_EQ(person.view.place, Place::list);
}

TEST(WatchView, DetailsStayOnTheirModuleWhenItIsGone) {
  Person person{3};
  person.press('\r');
  person.shown.targets.erase(person.shown.targets.begin());
  settle(person.view, person.shown);
  EXPECT_EQ(person.view.chosen, "robot.m0");
}

TEST(WatchView, WhatIsLongerThanTheScreenScrollsToItsEnd) {
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

TEST(WatchView, QuitsFromEverywhere) {
  for (const char key : {'?', 'c', '\r'}) {
    Person person{3};
    person.press(key);
    EXPECT_NE(person.view.place, Place::list);
    EXPECT_TRUE(person.press('q').quit);
  }
}

}  // namespace
}  // namespace takt::tool::watch::watch_view_test
