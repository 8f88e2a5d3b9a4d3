#include "watch/screen.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "reports/page.hpp"
#include "watch/line.hpp"
#include "watch/list.hpp"
#include "watch/pages.hpp"

namespace takt::tool::watch {

namespace {

std::string cells_of(const Snapshot& snapshot) {
  std::set<std::string> names;
  for (const Device& device : snapshot.devices) {
    if (!device.cell.empty()) names.insert(device.cell);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The title line: shows how many devices and modules there are, and how many of them are in a bad state or
/// not yet running.
Line title(const Snapshot& snapshot, std::size_t columns) {
  std::map<std::string, std::size_t> states;
  std::size_t modules = 0;
  std::set<std::string> bad;  // the states of modules that are bad
  std::size_t safe_stops = 0;
  std::size_t forced = 0;
  std::size_t alarms = 0;
  for (const Device& device : snapshot.devices) {
    alarms += device.alarms;
    modules += device.modules.size();
    for (const Module& module : device.modules) {
      const std::string state = device.alive ? module.state : "LOST";
      ++states[state];
      if (rating_of(device, module) == wire::Rating::bad) bad.insert(state);
      if (device.alive) safe_stops += module.safe_stop ? 1 : 0;
      if (device.alive) forced += module.forced ? 1 : 0;
    }
  }
  const auto lost = std::count_if(snapshot.devices.begin(), snapshot.devices.end(),
                                  [](const Device& d) { return !d.alive; });
  Line counts;
  counts.add(fmt::format("domain {}", snapshot.domain), Ink::dim)
      .gap(2)
      .add(count(snapshot.devices.size(), "device"));
  if (lost > 0) counts.add(fmt::format(", {} LOST", lost), Ink::bad);
  if (alarms > 0) counts.gap(2).add(count(alarms, "unacknowledged alarm"), Ink::bad);
  counts.gap(2).add(count(modules, "module"));
  for (const char* state : {"LOST", "RECOVER", "DESTRUCT", "IDLE", "INITIALIZE", "START"}) {
    const auto found = states.find(state);
    if (found == states.end()) continue;
    counts.gap(2).add(fmt::format("{} {}", found->second, state),
                      bad.contains(state) ? Ink::bad : Ink::plain);
  }
  if (safe_stops > 0) counts.gap(2).add(fmt::format("{} in a safe stop", safe_stops), Ink::warning);
  if (forced > 0) counts.gap(2).add(fmt::format("{} forced", forced), Ink::warning);
  if (safe_stops == 0 && forced == 0 && modules > 0 && states["EXECUTING"] == modules)
    counts.gap(2).add("all EXECUTING", Ink::good);
  const std::string cells = cells_of(snapshot);
  const std::size_t needed = counts.width() + cells.size() + (cells.empty() ? 0 : 2);
  const std::string program = "takt watch";
  Line line;
  if (needed + program.size() + 2 <= columns) line.add(program, Ink::dim).gap(2);
  if (!cells.empty()) line.add(cells, Ink::title).gap(2);
  line.add(counts);
  if (line.width() + 2 + snapshot.clock.size() <= columns)
    line.gap(columns - line.width() - snapshot.clock.size()).add(snapshot.clock, Ink::dim);
  return line;
}

/// The lines for the user's input, the question that the user must answer, or the result of the last key.
std::vector<Line> question(const Snapshot& snapshot, const View& view, std::size_t columns,
                           std::size_t rows) {
  Line line;
  if (view.typing) return {line.add("/", Ink::title).add(view.filter).add("_")};
  if (view.asked)
    return {line.add(
        fmt::format("{} {}? y: yes, any other key: no", to_text(view.asked->verb), view.asked->target),
        Ink::warning)};
  if (!view.filter.empty() && (view.page == Page::list || view.page == Page::connections))
    line.add("/" + view.filter, Ink::title).gap().add("(Esc: show all)", Ink::dim).gap(2);
  std::vector<Line> lines;
  if (line.width() + columns_of(view.message) > columns) {
    if (!line.empty()) lines.push_back(std::exchange(line, {}));
    const std::vector<std::string> parts = wrapped(view.message, columns);
    const std::size_t whole = std::min(parts.size(), std::max<std::size_t>(rows / 6, 1)) - 1;
    for (std::size_t i = 0; i < whole; ++i) lines.push_back(Line{}.add(parts[i]));
    lines.push_back(Line{}.add(
        fmt::format("{}", fmt::join(parts.begin() + static_cast<std::ptrdiff_t>(whole), parts.end(), " "))));
  } else {
    line.add(view.message);
  }
  for (const std::string& command : snapshot.commands)
    line.gap(line.empty() ? 0 : 2).add(command + " ...", Ink::warning);
  if (lines.empty() || !line.empty()) lines.push_back(line);
  return lines;
}

struct Key {
  const char* key;
  const char* text;
};

/// The keys of the commands that matter most for the selected module, or for all modules of a device.
std::vector<Key> command_keys(const Snapshot& snapshot, const View& view) {
  const Module* const module = snapshot.module(view.chosen);
  if (module == nullptr) return {{"s", "start"}, {"t", "stop"}};
  if (module->state == "IDLE") return {{"i", "initialize"}};
  if (module->state == "RECOVER") return {{"r", "recover"}};
  if (module->state == "DESTRUCT") return {{"x", "reset"}, {"R", "restart"}};
  if (module->state == "EXECUTING") return {{"t", "stop"}};
  return {{"s", "start"}};
}

Line keys(const Snapshot& snapshot, const View& view) {
  std::vector<Key> all;
  const auto add = [&all](const std::vector<Key>& more) { all.insert(all.end(), more.begin(), more.end()); };
  if (view.typing) {
    add({{"Enter", "keep"}, {"Esc", "show all"}});
  } else if (view.page == Page::details) {
    add({{"Esc", "back"}, {"n p", "next, previous"}});
    add(command_keys(snapshot, view));
    add({{"?", "all keys"}, {"q", "quit"}});
  } else if (view.page == Page::list) {
    add({{"Enter", "details"}, {"/", "find"}, {"< >", "sort"}, {"c", "connections"}});
    add(command_keys(snapshot, view));
    add({{"?", "keys"}, {"q", "quit"}});
  } else {
    add({{"Esc", "back"}, {"up down", "scroll"}, {"q", "quit"}});
  }
  Line line;
  for (const Key& each : all) {
    if (!line.empty()) line.gap(2);
    line.add(each.key, Ink::title).gap().add(each.text, Ink::dim);
  }
  return line;
}

/// The fixed lines above and below the scrolling part of the screen.
struct Around {
  std::vector<Line> above;
  std::vector<Line> below;
};

Around around(const Snapshot& snapshot, const View& view, std::size_t columns, std::size_t lines,
              ScreenStyle style) {
  Around around;
  around.above.push_back(title(snapshot, columns));
  if (view.page == Page::list) {
    around.above.push_back(list_heading(view, columns, style));
    // The last faults have half of the lines below the list, and the lines that the events leave.
    const std::size_t room = std::min(lines / 6, std::size_t{8});
    const std::size_t faults =
        std::min(snapshot.faults.size(), room - std::min(snapshot.events.size(), room / 2));
    const std::size_t events = std::min(snapshot.events.size(), room - faults);
    for (std::size_t i = snapshot.events.size() - events; i < snapshot.events.size(); ++i)
      around.below.push_back(Line{}.gap(2).add(snapshot.events[i], Ink::dim));
    for (std::size_t i = snapshot.faults.size() - faults; i < snapshot.faults.size(); ++i)
      around.below.push_back(
          Line{}.gap(2).add(snapshot.faults[i].text, snapshot.faults[i].error ? Ink::bad : Ink::warning));
  } else {
    around.above.push_back(Line{}.add(view.page == Page::details       ? view.chosen
                                      : view.page == Page::connections ? "connections"
                                                                       : "keys, columns and symbols",
                                      Ink::title));
  }
  for (Line& line : question(snapshot, view, columns, lines)) around.below.push_back(std::move(line));
  around.below.push_back(keys(snapshot, view));
  return around;
}

}  // namespace

Screen draw(const Snapshot& snapshot, View& view, std::size_t columns, std::size_t lines, ScreenStyle style) {
  Screen screen;
  const std::vector<Row> rows = rows_of(snapshot, view);
  for (const Row& row : rows) screen.shown.targets.push_back(row.target());
  Around outside = around(snapshot, view, columns, lines, style);
  const std::size_t taken = outside.above.size() + outside.below.size();
  screen.shown.room = lines > taken ? lines - taken : 1;
  std::vector<Line> page;
  if (view.page == Page::details) page = details_page(snapshot, view.chosen, columns, style);
  if (view.page == Page::connections) page = connections_page(snapshot, view.filter, columns, style);
  if (view.page == Page::help) page = help_page(style);
  screen.shown.length = page.size();
  settle(view, screen.shown);
  if (view.page == Page::list) {
    if (rows.empty()) {
      page.push_back(Line{}.gap(2).add(!snapshot.devices.empty() ? "no rows match the filter"
                                       : snapshot.searching      ? "searching for devices on this domain ..."
                                                                 : "no devices found on this domain",
                                       Ink::dim));
    }
    for (std::size_t i = view.first; i < rows.size() && i < view.first + screen.shown.room; ++i)
      page.push_back(list_line(rows[i], i == view.chosen_at, columns, style));
  } else {
    page.erase(page.begin(), page.begin() + static_cast<std::ptrdiff_t>(std::min(view.scroll, page.size())));
    if (page.size() > screen.shown.room) {  // the last visible line says how many lines are below it
      page.resize(screen.shown.room - 1);
      page.push_back(Line{}.gap(2).add(
          fmt::format("... {} more lines below", screen.shown.length - view.scroll - page.size()), Ink::dim));
    }
  }
  page.resize(screen.shown.room);

  std::vector<Line> all = std::move(outside.above);
  std::move(page.begin(), page.end(), std::back_inserter(all));
  std::move(outside.below.begin(), outside.below.end(), std::back_inserter(all));
  all.resize(std::max<std::size_t>(lines, 1));
  for (const Line& line : all) screen.lines.push_back(line.shown(columns, style));
  return screen;
}

std::string changes(const std::vector<std::string>& before, const std::vector<std::string>& now) {
  std::string text;
  const bool all = before.size() != now.size();
  if (all) text += "\033[H\033[J";
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!all && before[i] == now[i]) continue;
    // Clear the line before writing it. Clearing it afterwards could erase its last character, because the
    // cursor stays on a character written in the last column.
    text += fmt::format("\033[{};1H\033[K{}", i + 1, now[i]);
  }
  return text;
}

}  // namespace takt::tool::watch
