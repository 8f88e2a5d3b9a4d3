#include <watch_report.hpp>

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::tool {
namespace {

// Each line is cleared before it is written.
std::vector<std::string> lines_of(const std::string& screen) {
  constexpr std::size_t kClear = 3;
  std::vector<std::string> lines;
  std::size_t at = 0;
  while (screen.compare(at, kClear, "\033[K") == 0) {
    const std::size_t end = std::min(screen.find("\r\n", at), screen.size());
    lines.push_back(screen.substr(at + kClear, end - at - kClear));
    if (end == screen.size()) break;
    at = end + 2;
  }
  return lines;
}

std::vector<WatchRow> cell(std::size_t modules) {
  std::vector<WatchRow> rows(1);
  rows[0].device = "robot";
  rows[0].state = "running";
  for (std::size_t i = 0; i < modules; ++i) {
    WatchRow row;
    row.device = "robot";
    row.module = "m" + std::to_string(i);
    row.state = i == 1 ? "RECOVER" : "EXECUTING";
    row.measured = true;
    row.cycles = 1000 + i;
    rows.push_back(row);
  }
  return rows;
}

TEST(WatchScreen, FillsTheTerminalAndNoMore) {
  for (const std::size_t lines : {1, 5, 24, 60}) {
    for (const std::size_t columns : {20, 80, 200}) {
      WatchScreen screen{.selected = 2, .message = "robot.m1: EXECUTING", .events = {"one", "two"}};
      const auto shown = lines_of(watch_screen(cell(30), screen, columns, lines, {}));
      EXPECT_EQ(shown.size(), lines);
      for (const std::string& line : shown) EXPECT_LE(line.size(), columns);
    }
  }
}

TEST(WatchScreen, ShowsTheSelectedRowHoweverManyThereAre) {
  for (std::size_t selected = 0; selected <= 100; ++selected) {
    const auto rows = cell(100);
    const auto shown =
        lines_of(watch_screen(rows, {.selected = selected, .message = {}, .events = {}}, 80, 24, {}));
    EXPECT_EQ(
        std::count_if(shown.begin(), shown.end(), [](const std::string& l) { return l.rfind("> ", 0) == 0; }),
        1)
        << selected;
  }
}

TEST(WatchScreen, SaysStatesInWordsAndLossBeforeThem) {
  auto rows = cell(3);
  const std::string shown = watch_screen(rows, {}, 80, 24, {});
  EXPECT_THAT(shown, testing::HasSubstr("RECOVER"));
  EXPECT_THAT(shown, testing::Not(testing::HasSubstr("\033[3")));
  for (WatchRow& row : rows) row.lost = true;
  const std::string lost = watch_screen(rows, {}, 80, 24, {});
  EXPECT_THAT(lost, testing::HasSubstr("LOST"));
  EXPECT_THAT(lost, testing::Not(testing::HasSubstr("EXECUTING")));
}

TEST(WatchScreen, ColoursDoNotCountInTheWidth) {
  const std::string shown = watch_screen(cell(3), {}, 80, 24, {.colour = true});
  EXPECT_THAT(shown, testing::HasSubstr("\033[32mEXECUTING\033[0m"));
  EXPECT_THAT(shown, testing::HasSubstr("\033[31mRECOVER\033[0m"));
  EXPECT_THAT(shown, testing::HasSubstr("\033[32mrunning\033[0m"));
}

TEST(WatchScreen, ATextOfSeveralLinesStaysOnItsLine) {
  auto rows = cell(2);
  rows[2].text = "first\nsecond\x1b[2J";
  const auto shown =
      lines_of(watch_screen(rows, {.selected = 0, .message = "a\nb", .events = {"c\nd"}}, 120, 10, {}));
  ASSERT_EQ(shown.size(), 10);
  for (const std::string& line : shown) EXPECT_THAT(line, testing::Not(testing::ContainsRegex("[\n\x1b]")));
  EXPECT_THAT(shown[3], testing::HasSubstr("first\\nsecond\\x1b[2J"));
}

TEST(WatchScreen, IsCutBetweenCharacters) {
  auto rows = cell(0);
  rows[0].text = "ä€ö";
  const std::size_t begin = lines_of(watch_screen(rows, {}, 200, 5, {}))[1].find("ä");
  for (const auto& [more, seen] : {std::pair{1, "ä"}, {2, "ä€"}, {3, "ä€ö"}, {4, "ä€ö"}}) {
    const auto shown = lines_of(watch_screen(rows, {}, begin + static_cast<std::size_t>(more), 5, {}));
    EXPECT_EQ(shown[1].substr(begin), seen);
  }
}

TEST(WatchScreen, SaysSoWhereThereIsNothing) {
  EXPECT_THAT(watch_screen({}, {}, 80, 24, {}), testing::HasSubstr("no device is to be seen"));
}

}  // namespace
}  // namespace takt::tool
