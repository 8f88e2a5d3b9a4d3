#include "watch_report.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>

#include <fmt/format.h>

#include <takt/core/words.hpp>

namespace takt::tool {

namespace {

constexpr const char* kHelp =
    "arrows choose   s start   t stop   r recover   x reset   i initialize   q quit";
constexpr std::size_t kEvents = 4;

// Each character takes a column; none is cut in two.
std::string cut(std::string text, std::size_t columns) {
  std::size_t at = 0;
  for (; at < text.size() && columns > 0; --columns)
    at += std::max<std::size_t>(utf8_length(std::string_view{text}.substr(at)), 1);
  text.resize(std::min(at, text.size()));
  return text;
}

const char* colour_of(const WatchRow& row) {
  if (row.lost) return "\033[31m";
  if (row.state == "EXECUTING" || row.state == "running") return "\033[32m";
  if (row.state == "RECOVER" || row.state == "DESTRUCT") return "\033[31m";
  return "\033[33m";
}

std::string line_of(const WatchRow& row, bool selected, std::size_t columns, bool colour) {
  const std::string name = row.module.empty() ? row.device : "  " + row.module;
  const std::string state = row.lost ? "LOST" : row.state;
  std::string line = fmt::format("{} {:<22.22} ", selected ? '>' : ' ', name);
  const std::size_t state_at = line.size();
  line += fmt::format("{:<10}", state);
  if (!row.module.empty() && row.measured) {
    line += fmt::format(" {:>11} {:>8.2f} {:>8.2f} {:>8} {:>6}", row.cycles, row.jitter_p50_us,
                        row.jitter_p99_us, row.overruns, row.errors);
  }
  if (!row.text.empty()) line += "  " + on_one_line(row.text);
  line = cut(line, columns);
  if (colour && line.size() >= state_at + state.size())
    line =
        line.substr(0, state_at) + colour_of(row) + state + "\033[0m" + line.substr(state_at + state.size());
  return line;
}

}  // namespace

std::string watch_screen(const std::vector<WatchRow>& rows, const WatchScreen& screen, std::size_t columns,
                         std::size_t lines, Style style) {
  std::vector<std::string> all;
  all.push_back(cut(fmt::format("  {:<22} {:<10} {:>11} {:>8} {:>8} {:>8} {:>6}", "device, module", "state",
                                "cycles", "p50 us", "p99 us", "overruns", "errors"),
                    columns));
  const std::size_t events = std::min(kEvents, screen.events.size());
  const std::size_t around = 1 + 1 + events + 1;  // the heading, the message, the events, the keys
  const std::size_t room = lines > around ? lines - around : 1;
  const std::size_t first = screen.selected >= room ? screen.selected - room + 1 : 0;
  for (std::size_t i = first; i < rows.size() && i < first + room; ++i)
    all.push_back(line_of(rows[i], i == screen.selected, columns, style.colour));
  if (rows.empty()) all.push_back(cut("  no device is to be seen on this domain", columns));
  while (all.size() < room + 1) all.emplace_back();
  for (std::size_t i = screen.events.size() - events; i < screen.events.size(); ++i)
    all.push_back(cut("  " + on_one_line(screen.events[i]), columns));
  all.push_back(cut(on_one_line(screen.message), columns));
  all.push_back(cut(kHelp, columns));
  all.resize(std::max<std::size_t>(lines, 1));

  std::string text;
  // Cleared before it is written: after a character in the last column the cursor is still on it.
  for (std::size_t i = 0; i < all.size(); ++i) text += (i == 0 ? "\033[K" : "\r\n\033[K") + all[i];
  return text;
}

std::string clock_text(std::int64_t wall_ns) {
  const std::time_t seconds = wall_ns / 1'000'000'000;
  std::tm parts{};
  ::localtime_r(&seconds, &parts);
  return fmt::format("{:02}:{:02}:{:02}.{:03}", parts.tm_hour, parts.tm_min, parts.tm_sec,
                     wall_ns / 1'000'000 % 1000);
}

}  // namespace takt::tool
