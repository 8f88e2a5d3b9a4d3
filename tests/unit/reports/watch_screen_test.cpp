#include <watch/screen.hpp>

#include <algorithm>

#include <gmock/gmock.h>

#include <watch/line.hpp>

#include "watch_cells.hpp"

namespace takt::tool::watch::watch_screen_test {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

TEST(WatchScreen, EveryPageFitsATerminalOfAnySize) {
  Snapshot snapshot = cell(30);
  snapshot.connections_known = true;
  snapshot.events = {"one", std::string(300, 'e'), "three"};
  snapshot.faults = {{.text = "four"}, {.text = std::string(300, 'f'), .error = true}};
  snapshot.commands = {"stop of robot.m3, 2 s"};
  snapshot.devices[1].modules[3].text = std::string(500, 't');
  snapshot.devices[1].modules[3].ports = {{.name = std::string(80, 'p'), .type = std::string(80, 't')}};
  for (int i = 0; i < 40; ++i) {
    snapshot.connections.push_back({.from = std::string(90, 'f'),
                                    .to = std::string(90, 'o'),
                                    .kind = "latest",
                                    .health = CellHealth::Connection{}});
  }
  for (const Page page : {Page::list, Page::details, Page::connections, Page::help}) {
    for (const std::size_t lines : {1U, 2U, 3U, 4U, 5U, 8U, 24U, 60U}) {
      for (const std::size_t columns : {1U, 2U, 5U, 20U, 40U, 79U, 80U, 81U, 100U, 133U, 200U, 400U}) {
        for (const bool unicode : {false, true}) {
          View view{.page = page, .chosen = "robot.m3", .message = std::string(200, 'm')};
          const Screen screen = draw(snapshot, view, columns, lines, {.unicode = unicode});
          ASSERT_THAT(screen.lines, SizeIs(lines));
          for (const std::string& line : screen.lines) ASSERT_LE(columns_of(line), columns) << line;
        }
      }
    }
  }
}

TEST(WatchScreen, AlwaysShowsTheSelectedRow) {
  const Snapshot snapshot = cell(100);
  View view;
  Shown shown = draw(snapshot, view, 80, 24, {}).shown;
  for (std::size_t i = 0; i < shown.targets.size(); ++i) {
    view.chosen = shown.targets[i];
    const Screen screen = draw(snapshot, view, 80, 24, {});
    const auto chosen = [](const std::string& line) { return line.starts_with("> "); };
    EXPECT_EQ(std::count_if(screen.lines.begin(), screen.lines.end(), chosen), 1) << view.chosen;
  }
  EXPECT_THAT(shown.targets, SizeIs(103));
}

TEST(WatchScreen, CountsDevicesAndModulesWithProblemsInItsTitle) {
  Snapshot snapshot = cell(3);
  EXPECT_THAT(drawn(snapshot), StartsWith("takt watch  cell  domain 7  2 devices  4 modules  1 RECOVER"));
  snapshot.devices[0].modules[0].state = "EXECUTING";
  EXPECT_THAT(drawn(snapshot), HasSubstr("2 devices  4 modules  all EXECUTING"));
  snapshot.devices[1].alive = false;
  EXPECT_THAT(drawn(snapshot), HasSubstr("2 devices, 1 LOST  4 modules  3 LOST"));
  EXPECT_THAT(draw(snapshot, *std::make_unique<View>(), 80, 24, {}).lines[0], testing::EndsWith("12:34:56"));
}

TEST(WatchScreen, ShowsALostDeviceAsLostInsteadOfItsLastState) {
  Snapshot snapshot = cell(3);
  EXPECT_THAT(drawn(snapshot), HasSubstr("! RECOVER"));
  EXPECT_THAT(drawn(snapshot), HasSubstr("* EXECUTING"));
  EXPECT_THAT(drawn(snapshot), Not(HasSubstr("\033")));
  for (Device& device : snapshot.devices) device.alive = false;
  EXPECT_THAT(drawn(snapshot), HasSubstr("X LOST"));
  EXPECT_THAT(drawn(snapshot), Not(HasSubstr("EXECUTING")));
}

TEST(WatchScreen, ShowsGoodAndBadStatesInDifferentColours) {
  const ScreenStyle style{.colour = true, .unicode = true};
  const std::string shown = drawn(cell(3), {.chosen = "robot"}, 80, 24, style);
  EXPECT_THAT(shown, HasSubstr("\033[32m● EXECUTING"));
  EXPECT_THAT(shown, HasSubstr("\033[31m▲ RECOVER"));
  EXPECT_THAT(shown, HasSubstr("\033[32;1m● running"));  // the selected row is bold
}

TEST(WatchScreen, ShortensACountThatDoesNotFit) {
  const auto shown = [](std::uint64_t number, std::size_t columns) {
    return Line{}.count(number, columns).shown(columns, ScreenStyle{});
  };
  EXPECT_EQ(shown(1234, 6), "  1234");
  EXPECT_EQ(shown(12'345, 4), " 12k");
  EXPECT_EQ(shown(100'000'000, 8), " 100000k");
  EXPECT_EQ(shown(100'000'000, 5), " 100M");
  EXPECT_EQ(shown(18'446'744'073'709'551'615U, 4), " 18E");
}

TEST(WatchScreen, ShowsTheLastFaultsAndEventsBelowTheList) {
  const auto below = [](std::size_t events, std::size_t faults) {
    Snapshot snapshot = cell(30);
    for (std::size_t i = 0; i < events; ++i) snapshot.events.push_back("event " + std::to_string(i));
    for (std::size_t i = 0; i < faults; ++i)
      snapshot.faults.push_back({.text = "fault " + std::to_string(i)});
    View view;
    std::vector<std::string> found;
    for (const std::string& line : draw(snapshot, view, 80, 24, {}).lines) {
      if (line.starts_with("  event") || line.starts_with("  fault")) found.push_back(line.substr(2));
    }
    return found;
  };
  using testing::ElementsAre;
  EXPECT_THAT(below(9, 9), ElementsAre("event 7", "event 8", "fault 7", "fault 8"));
  EXPECT_THAT(below(1, 9), ElementsAre("event 0", "fault 6", "fault 7", "fault 8"));
  EXPECT_THAT(below(9, 1), ElementsAre("event 6", "event 7", "event 8", "fault 0"));
  EXPECT_THAT(below(1, 0), ElementsAre("event 0"));
}

TEST(WatchScreen, EscapesControlCharactersInTexts) {
  Snapshot snapshot = cell(1);
  snapshot.devices[0].modules[0].text = "first\nsecond\x1b[2J";
  snapshot.events = {"c\nd"};
  snapshot.faults = {{.text = "e\x1b[2J\nf"}};
  const std::string shown = drawn(snapshot, {.message = "a\x1b]0;b\nb"}, 120, 24);
  EXPECT_THAT(shown, Not(ContainsRegex("\x1b")));
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 24);
  EXPECT_THAT(shown, HasSubstr("first\\nsecond\\x1b[2J"));
}

TEST(WatchScreen, ExplainsWhyAPageIsEmpty) {
  EXPECT_THAT(drawn({.searching = true}), HasSubstr("searching for devices on this domain ..."));
  EXPECT_THAT(drawn({}), HasSubstr("no devices found on this domain"));
  EXPECT_THAT(drawn(cell(2), {.filter = "nonsense"}), HasSubstr("no rows match the filter"));
  EXPECT_THAT(drawn(cell(2), {.page = Page::connections}),
              HasSubstr("no node has reported the connections yet"));
  EXPECT_THAT(drawn(cell(2), {.page = Page::details, .chosen = "robot.m7"}),
              HasSubstr("robot.m7 no longer exists"));
}

TEST(WatchScreen, AsksForConfirmationOfACommand) {
  EXPECT_THAT(drawn(cell(2), {.asked = Command{Verb::destruct, "robot.m1"}}),
              HasSubstr("destruct robot.m1? y: yes, any other key: no"));
}

TEST(WatchScreen, WrapsALongAnswerToSeveralLines) {
  View view{.message = "module robot.m3: stop is not allowed in state DESTRUCT; it is allowed in EXECUTING"};
  const Screen screen = draw(cell(3), view, 80, 24, {});
  EXPECT_EQ(screen.lines[21], "module robot.m3: stop is not allowed in state DESTRUCT; it is allowed in");
  EXPECT_EQ(screen.lines[22], "EXECUTING");
}

TEST(WatchScreen, OffersTheCommandsThatTheStateOfTheSelectedModuleAllows) {
  Snapshot snapshot = cell(3);
  View view{.pressed = true, .chosen = "robot.m1"};
  const auto keys = [&] { return draw(snapshot, view, 80, 24, {}).lines.back(); };
  EXPECT_THAT(keys(), AllOf(HasSubstr("t stop"), Not(HasSubstr("s start"))));
  for (Device& device : snapshot.devices) {
    for (Module& module : device.modules) module.state = "DESTRUCT";
  }
  EXPECT_THAT(keys(), AllOf(HasSubstr("x reset  R restart"), Not(HasSubstr("stop"))));
  view.chosen = "robot";
  EXPECT_THAT(keys(), HasSubstr("s start  t stop")) << "a device may have modules in any state";
}

TEST(WatchScreen, ListsCommandsThatAreNotYetAnswered) {
  Snapshot snapshot = cell(2);
  snapshot.commands = {"stop of robot.m1, 3 s"};
  EXPECT_THAT(drawn(snapshot), HasSubstr("stop of robot.m1, 3 s ..."));
}

TEST(WatchScreen, SaysHowManyLinesOfALongPageAreBelow) {
  View view{.page = Page::help};
  const Screen screen = draw(cell(2), view, 80, 10, {});
  const std::size_t visible = screen.shown.room - 1;
  EXPECT_THAT(text_of(screen),
              HasSubstr("... " + std::to_string(screen.shown.length - visible) + " more lines below"));
  view.scroll = 1000;
  EXPECT_THAT(text_of(draw(cell(2), view, 80, 10, {})), Not(HasSubstr("more lines below")));
  EXPECT_EQ(view.scroll, screen.shown.length - screen.shown.room);
}

TEST(WatchScreen, SendsOnlyChangedLinesToTheTerminal) {
  EXPECT_EQ(changes({"a", "b", "c"}, {"a", "x", "c"}), "\033[2;1H\033[Kx");
  EXPECT_EQ(changes({"a"}, {"a"}), "");
  EXPECT_EQ(changes({}, {"a", "b"}), "\033[H\033[J\033[1;1H\033[Ka\033[2;1H\033[Kb");
}

TEST(WatchLine, IsCutBetweenCharactersAndMarksTheCut) {
  Line line;
  line.add("ä€ö");
  EXPECT_EQ(line.shown(3, {.unicode = true}), "ä€ö");
  EXPECT_EQ(line.shown(2, {.unicode = true}), "ä…");
  EXPECT_EQ(line.shown(1, {.unicode = true}), "…");
  EXPECT_EQ(line.shown(0, {.unicode = true}), "");
  EXPECT_EQ(line.shown(3, {}), "???");
  EXPECT_EQ(line.shown(2, {}), "?~");
  EXPECT_EQ(Line{}.left("12345", 4).add("|").shown(80, {}), "123~|");
  EXPECT_EQ(Line{}.left("12", 4).add("|").shown(80, {}), "12  |");
  EXPECT_EQ(Line{}.right("12", 4).add("|").shown(80, {}), "  12|");
  EXPECT_EQ(Line{}.right("12345", 4).add("|").shown(80, {}), "123~|");
}

}  // namespace
}  // namespace takt::tool::watch::watch_screen_test
