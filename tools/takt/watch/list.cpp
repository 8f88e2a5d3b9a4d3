#include "watch/list.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

#include <fmt/format.h>

#include "reports/run_report.hpp"
#include "watch/sparkline.hpp"

namespace takt::tool::watch {

namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

struct Sign {
  const char* unicode;
  const char* ascii;
};
constexpr Sign kRuns{"●", "*"};
constexpr Sign kReady{"○", "o"};
constexpr Sign kNotYet{"·", "."};
constexpr Sign kTrouble{"▲", "!"};
constexpr Sign kOver{"■", "x"};
constexpr Sign kLost{"✖", "X"};

State state(const Sign& sign, const std::string& word, Ink ink, ScreenStyle style) {
  return {std::string{style.unicode ? sign.unicode : sign.ascii} + " " + word, ink};
}

/// The colour of a rating.
Ink ink_of(wire::Rating rating) {
  switch (rating) {
    case wire::Rating::good:
      return Ink::good;
    case wire::Rating::idle:
      return Ink::plain;
    case wire::Rating::poor:
      return Ink::warning;
    case wire::Rating::bad:
    case wire::Rating::broken:
      break;
  }
  return Ink::bad;
}

// The rank of a row in a list that is sorted by state: the worst state has rank 0.
int rank_of(const Row& row) {
  if (!row.device->alive) return 0;
  if (row.module == nullptr) return row.device->health == "ok" ? 7 : 1;
  constexpr std::array kWorstFirst{"RECOVER", "DESTRUCT", "IDLE", "INITIALIZE", "START", "EXECUTING"};
  const auto found = std::find(kWorstFirst.begin(), kWorstFirst.end(), row.module->state);
  return 1 + static_cast<int>(found - kWorstFirst.begin());
}

double number_of(const Row& row, Column column) {
  if (row.module == nullptr || !row.module->measured) return -std::numeric_limits<double>::infinity();
  const Measured& m = *row.module->measured;
  switch (column) {
    case Column::p50:
      return m.jitter_us.p50;
    case Column::p99:
      return m.jitter_us.p99;
    case Column::budget:
      return row.module->share(m.run_us.p99).value_or(-1);
    case Column::overruns:
      return static_cast<double>(m.overruns);
    case Column::errors:
      return static_cast<double>(m.errors);
    case Column::cycles:
      return static_cast<double>(m.cycles);
    case Column::missed:
      return static_cast<double>(m.missed);
    case Column::name:
    case Column::state:
      break;
  }
  return 0;
}

bool is_before(const Row& a, const Row& b, Column column) {
  if (column == Column::name) return a.target() < b.target();
  if (column == Column::state) return rank_of(a) < rank_of(b);
  return number_of(a, column) > number_of(b, column);  // larger numbers come first
}

std::string words_of(const Device& device) {
  return device.name + " " + (device.alive ? device.state : "LOST") + " " + device.text;
}

std::string words_of(const Device& device, const Module& module) {
  return device.name + "." + module.name + " " + (device.alive ? module.state : "LOST") + " " + module.text;
}

// Sorts the devices by name, and the modules below each device by name. If `view.reversed`, both orders are
// reversed.
std::vector<Row> below_their_devices(const Snapshot& snapshot, const View& view) {
  const auto ends = [&view](auto& all, const auto& is_less) {
    std::stable_sort(all.begin(), all.end(), is_less);
    if (view.reversed) std::reverse(all.begin(), all.end());
  };
  std::vector<const Device*> devices;
  for (const Device& device : snapshot.devices) devices.push_back(&device);
  ends(devices, [](const Device* a, const Device* b) { return a->name < b->name; });
  std::vector<Row> rows;
  for (const Device* device : devices) {
    std::vector<const Module*> modules;
    for (const Module& module : device->modules) {
      if (matches(words_of(*device, module), view.filter)) modules.push_back(&module);
    }
    ends(modules, [](const Module* a, const Module* b) { return a->name < b->name; });
    if (modules.empty() && !matches(words_of(*device), view.filter)) continue;
    rows.push_back({.device = device});
    for (const Module* module : modules) rows.push_back({.device = device, .module = module});
  }
  return rows;
}

/// The layout of one column. `kNeed` lists the columns by importance, the most important first.
struct Laid {
  const char* heading;
  std::size_t width;
  std::optional<Column> column{};
};
constexpr std::array kLaid{
    Laid{"device, module", 18, Column::name},
    Laid{"state", 12, Column::state},
    Laid{"p50 us", 7, Column::p50},
    Laid{"p99 us", 7, Column::p99},
    Laid{"last minute", 11},
    Laid{"budget", 6, Column::budget},
    Laid{"over", 5, Column::overruns},
    Laid{"err", 4, Column::errors},
    Laid{"cycles", 12, Column::cycles},
    Laid{"missed", 8, Column::missed},
    Laid{"recov.", 6},
    Laid{"why", 30},
};
constexpr std::size_t kName = 0, kState = 1, kMinute = 4, kRecoveries = 10, kWhy = 11;
constexpr std::array<std::size_t, kLaid.size()> kNeed{0, 1, 3, 7, 6, 5, 2, 4, 8, 9, 10, 11};
constexpr std::size_t kMark = 2;

/// The space before a column. The chart needs a wider gap than a column of numbers, because its heading is
/// not right-aligned.
constexpr std::size_t gap_before(std::size_t i) { return i == kName ? 0 : i == kMinute ? 2 : 1; }
constexpr std::size_t kLongestName = 34;

/// The width of each column of the list, or 0 for a column that is not shown.
std::array<std::size_t, kLaid.size()> widths_of(std::size_t columns) {
  std::array<std::size_t, kLaid.size()> widths{};
  std::size_t room = columns < kMark ? 0 : columns - kMark;
  for (const std::size_t i : kNeed) {
    const std::size_t needed = kLaid.at(i).width + gap_before(i);
    if (needed > room) break;
    widths.at(i) = kLaid.at(i).width;
    room -= needed;
  }
  if (widths.at(kName) == 0) widths.at(kName) = room, room = 0;
  const auto widen = [&](std::size_t i, std::size_t most) {
    if (widths.at(i) == 0) return;
    const std::size_t more = std::min(room, std::max(most, widths.at(i)) - widths.at(i));
    widths.at(i) += more;
    room -= more;
  };
  widen(kState, 17);
  widen(kMinute, 30);
  widen(kName, kLongestName);
  widen(kMinute, 60);
  widen(kWhy, 1000);
  return widths;
}

Ink ink_of_share(double share) { return share > 1 ? Ink::bad : share > 0.8 ? Ink::warning : Ink::plain; }

void measured_columns(Line& line, const Row& row, const std::array<std::size_t, kLaid.size()>& widths,
                      ScreenStyle style) {
  const Module& module = *row.module;
  const Measured m = module.measured.value_or(Measured{});
  const auto number = [&](std::size_t i, const std::string& text, Ink ink = Ink::plain) {
    if (widths.at(i) > 0)
      line.gap().right(module.measured ? text : "-", widths.at(i), module.measured ? ink : Ink::dim);
  };
  const auto count = [&](std::size_t i, std::uint64_t of, Ink ink = Ink::plain) {
    if (!module.measured)
      number(i, "");
    else if (widths.at(i) > 0)
      line.gap().count(of, widths.at(i), of == 0 ? Ink::plain : ink);
  };
  number(2, in_us(m.jitter_us.p50));
  number(3, in_us(m.jitter_us.p99));
  if (widths.at(kMinute) > 0) {
    line.gap(gap_before(kMinute))
        .left(sparkline(module.minute_us, std::min<std::size_t>(widths.at(kMinute), 60), style),
              widths.at(kMinute));
  }
  const auto share = module.share(m.run_us.p99);
  number(5, share ? fmt::format("{:.0f} %", *share * 100) : "-", share ? ink_of_share(*share) : Ink::dim);
  count(6, m.overruns, Ink::warning);
  count(7, m.errors, Ink::bad);
  count(8, m.cycles);
  count(9, m.missed, Ink::warning);
  count(kRecoveries, m.recoveries, Ink::warning);
}

}  // namespace

std::string Row::target() const {
  return module == nullptr ? device->name : device->name + "." + module->name;
}

bool matches(const std::string& text, const std::string& filter) {
  std::istringstream words{lower(filter)};
  const std::string all = lower(text);
  for (std::string word; words >> word;) {
    if (all.find(word) == std::string::npos) return false;
  }
  return true;
}

wire::Rating rating_of(const Device& device) {
  return wire::judge(
      wire::DeviceReport{.state = device.state, .health = device.health, .alive = device.alive});
}

wire::Rating rating_of(const Device& device, const Module& module) {
  return wire::judge(wire::ModuleReport{.state = module.state,
                                        .lost = !device.alive,
                                        .given_up = module.given_up,
                                        .safe_stop = module.safe_stop,
                                        .forced = module.forced});
}

State state_of(const Device& device, ScreenStyle style) {
  if (!device.alive) return state(kLost, "LOST", Ink::bad, style);
  const wire::Rating rating = rating_of(device);
  const Sign& sign = rating == wire::Rating::good   ? kRuns
                     : rating != wire::Rating::idle ? kTrouble
                     : device.state == "waiting"    ? kReady
                                                    : kNotYet;
  return state(sign, device.state, ink_of(rating), style);
}

State state_of(const Device& device, const Module& module, ScreenStyle style) {
  if (!device.alive) return state(kLost, "LOST", Ink::bad, style);
  const wire::Rating rating = rating_of(device, module);
  if (module.state == "DESTRUCT")
    return state(kOver, module.state, rating == wire::Rating::idle ? Ink::dim : ink_of(rating), style);
  const Sign& sign = rating == wire::Rating::good   ? kRuns
                     : rating != wire::Rating::idle ? kTrouble
                     : module.state == "START"      ? kReady
                                                    : kNotYet;
  return state(sign,
               module.safe_stop ? "safe stop"
               : module.forced  ? "forced"
                                : module.state,
               ink_of(rating), style);
}

State state_of(const Connection& connection, ScreenStyle style) {
  if (!connection.health) return state(kNotYet, "not reported", Ink::dim, style);
  const CellHealth::Connection& health = *connection.health;
  const std::string text = health_text(health);
  const wire::Rating rating = wire::judge(health).rating;
  const Sign& sign = rating == wire::Rating::good ? kRuns : rating == wire::Rating::broken ? kLost : kTrouble;
  return state(sign, text, ink_of(rating), style);
}

std::vector<Row> rows_of(const Snapshot& snapshot, const View& view) {
  if (view.column == Column::name) return below_their_devices(snapshot, view);
  std::vector<Row> rows;
  for (const Device& device : snapshot.devices) {
    if (device.modules.empty() && matches(words_of(device), view.filter))
      rows.push_back({.device = &device, .alone = true});
    for (const Module& module : device.modules) {
      if (matches(words_of(device, module), view.filter))
        rows.push_back({.device = &device, .module = &module, .alone = true});
    }
  }
  std::stable_sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) {
    return view.reversed ? is_before(b, a, view.column) : is_before(a, b, view.column);
  });
  return rows;
}

Line list_heading(const View& view, std::size_t columns, ScreenStyle style) {
  const auto widths = widths_of(columns);
  Line line;
  line.gap(kMark);
  for (std::size_t i = 0; i < kLaid.size(); ++i) {
    const Laid& laid = kLaid.at(i);
    if (widths.at(i) == 0) continue;
    line.gap(gap_before(i));
    std::string text = laid.heading;
    if (laid.column == view.column) {
      const bool falls = (view.column == Column::name || view.column == Column::state) == view.reversed;
      text = (falls ? (style.unicode ? "▼" : "v") : (style.unicode ? "▲" : "^")) + text;
    }
    const bool is_number = i >= 2 && i != kMinute && i != kWhy;
    is_number ? line.right(text, widths.at(i), Ink::title) : line.left(text, widths.at(i), Ink::title);
  }
  return line;
}

Line list_line(const Row& row, bool chosen, std::size_t columns, ScreenStyle style) {
  const auto widths = widths_of(columns);
  const std::string name = row.module == nullptr ? row.device->name
                           : row.alone           ? row.target()
                                                 : "  " + row.module->name;
  const State state =
      row.module == nullptr ? state_of(*row.device, style) : state_of(*row.device, *row.module, style);
  const std::string& why = row.module == nullptr ? row.device->text : row.module->text;
  Line line;
  line.add(chosen ? "> " : "  ").left(name, widths.at(kName));
  std::string word = state_text(state.text, row.module != nullptr && row.module->stopped);
  if (columns_of(word) > widths.at(kState)) word = state.text;
  if (widths.at(kState) > 0) line.gap().left(word, widths.at(kState), state.ink);
  // If the line is too short for both the numbers and the reason, show only the reason. The details page
  // shows the numbers.
  if (row.module == nullptr || (!why.empty() && widths.at(kWhy) == 0)) {
    if (!why.empty()) line.gap().add(why);
  } else {
    measured_columns(line, row, widths, style);
    if (!why.empty()) line.gap().add(why);
  }
  return chosen ? line.chosen() : line;
}

}  // namespace takt::tool::watch
