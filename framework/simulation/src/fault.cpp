#include <takt/simulation/fault.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <takt/core/words.hpp>

namespace takt::simulation {

namespace {

using Kind = Fault::Kind;

enum class Of { module, executor, device, devices, connection };
enum class Amount { none, duration, count };

struct Word {
  Kind kind;
  Of of;
  std::string_view word;
  Amount amount;
  std::string_view example;
  std::string_view means;
};

constexpr std::array kFaultWords{
    Word{Kind::late, Of::module, "late", Amount::duration, "robot.servo late 3 ms",
         "the module's next run takes 3 ms longer"},
    Word{Kind::crash, Of::module, "crash", Amount::none, "line.belt crash",
         "the module's next run crashes its host or program"},
    Word{Kind::fail, Of::module, "fail", Amount::none, "robot.servo fail",
         "the module's next run reports a failure"},
    Word{Kind::hang, Of::module, "hang", Amount::none, "robot.servo hang",
         "the module's next run never returns"},
    Word{Kind::unmended, Of::module, "unmended", Amount::count, "robot.servo unmended 2",
         "the module's next two recovery attempts fail"},
    Word{Kind::oversleep, Of::executor, "oversleep", Amount::duration, "robot.motion oversleep 3 ms",
         "the executor's next wake-up is 3 ms late"},
    Word{Kind::clock_step, Of::device, "clock-step", Amount::duration, "robot clock-step -2 ms",
         "the device's wall clock is set back by 2 ms"},
    Word{Kind::cut, Of::devices, "cut for", Amount::duration, "link robot line cut for 500 ms",
         "no sample passes between the two devices"},
    Word{Kind::lose, Of::connection, "lose", Amount::count, "connection robot.arm.state lose 3",
         "the output's next three samples to other devices are lost"},
    Word{Kind::delay, Of::connection, "late", Amount::duration, "connection robot.arm.state late 5 ms",
         "the output's next sample to other devices takes 5 ms longer"},
    Word{Kind::initialize, Of::module, "initialize", Amount::none, "robot.servo initialize",
         "an operator sends a command, as with takt initialize"},
    Word{Kind::start, Of::module, "start", Amount::none, "robot.servo start", "as with takt start"},
    Word{Kind::stop, Of::module, "stop", Amount::none, "robot.servo stop", "as with takt stop"},
    Word{Kind::recover, Of::module, "recover", Amount::none, "robot.servo recover", "as with takt recover"},
    Word{Kind::reset, Of::module, "reset", Amount::none, "robot.servo reset", "as with takt reset"},
    Word{Kind::destruct, Of::module, "destruct", Amount::none, "robot.servo destruct",
         "as with takt destruct"},
    Word{Kind::swap, Of::module, "swap", Amount::none, "robot.servo swap",
         "an update replaces the module's instance while it runs"},
};
/// The number of faults, which come first in kFaultWords. The commands follow.
constexpr std::uint64_t kFaultKinds = static_cast<std::uint64_t>(Kind::delay) + 1;

using channel::Doing;

/// The calls of a thread module in which a script may inject a fault.
constexpr std::array<std::pair<std::string_view, Doing>, 6> kHooks{{{"load", Doing::load},
                                                                    {"initialize", Doing::initialize},
                                                                    {"start", Doing::start},
                                                                    {"error", Doing::error},
                                                                    {"recover", Doing::recover},
                                                                    {"destruct", Doing::destruct}}};

bool may_name_hook(Kind kind) { return kind == Kind::crash || kind == Kind::fail || kind == Kind::hang; }

const Word& word_of(Kind kind) {
  return *std::find_if(kFaultWords.begin(), kFaultWords.end(),
                       [kind](const Word& word) { return word.kind == kind; });
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool crosses(const model::Connection& connection) {
  return connection.from.given() && connection.to.given() &&
         (connection.from.device != connection.to.device || !connection.topic.empty());
}

class Line {
 public:
  Line(std::string_view text, std::string where, const model::Cell& cell)
      : words_(split(text)), where_(std::move(where)), cell_(cell) {}

  Result<std::vector<Fault>> read() {
    Fault fault;
    if (next() != "at")
      return wrong("the line does not begin with 'at'", "write, for example, at 1.5 s robot.servo late 3 ms");
    const auto at = duration();
    if (!at || *at < Nanoseconds{0})
      return wrong("there is no time since T0 after 'at'", "write, for example, at 1.5 s or at 20 ms");
    fault.at = *at;

    std::vector<Fault> places;
    Of of = Of::module;
    if (peek() == "link") {
      next();
      const auto a = device(next());
      if (!a) return *problem_;
      const auto b = device(next());
      if (!b) return *problem_;
      if (*a == *b)
        return wrong("a link is between two different devices",
                     "write, for example, link robot line cut for 500 ms");
      of = Of::devices;
      fault.device = *a;
      fault.place = *b;
      places.push_back(fault);
    } else if (peek() == "connection") {
      next();
      of = Of::connection;
      if (!connections(next(), fault, places)) return *problem_;
    } else if (!place(next(), fault, places, of)) {
      return *problem_;
    }

    if (!what(of, places)) return *problem_;
    if (!peek().empty())
      return wrong("the line continues after the fault: " + in_quotes(peek()), "write one fault per line");
    return places;
  }

 private:
  [[nodiscard]] std::string_view peek() const {
    return at_ < words_.size() ? words_[at_] : std::string_view{};
  }
  std::string_view next() { return at_ < words_.size() ? words_[at_++] : std::string_view{}; }
  Problem wrong(std::string what, std::string fix) {
    problem_ = Problem{where_, std::move(what), std::move(fix)};
    return *problem_;
  }

  /// Reads a duration such as "1.5 s", "1.5s" or "-2 ms".
  std::optional<Nanoseconds> duration() {
    std::string_view number = next();
    const std::size_t digits = std::min(number.find_first_not_of("+-.0123456789"), number.size());
    std::string_view unit = number.substr(digits);
    number = number.substr(0, digits);
    if (unit.empty()) unit = next();
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (number.empty() || error != std::errc{} || end != number.data() + number.size()) return std::nullopt;
    const double scale = unit == "ns" ? 1 : unit == "us" ? 1e3 : unit == "ms" ? 1e6 : unit == "s" ? 1e9 : 0;
    if (scale == 0 || !(std::abs(value * scale) < 1e18)) return std::nullopt;
    return Nanoseconds{std::llround(value * scale)};
  }

  std::optional<std::uint32_t> device(std::string_view name) {
    std::vector<std::string_view> known;
    for (std::uint32_t i = 0; i < cell_.devices.size(); ++i) {
      if (cell_.devices[i].name == name) return i;
      known.emplace_back(cell_.devices[i].name);
    }
    wrong("there is no device " + in_quotes(name), suggestion(name, known));
    return std::nullopt;
  }

  /// Reads DEVICE, DEVICE.MODULE or DEVICE.EXECUTOR, depending on the fault.
  bool place(std::string_view name, Fault& fault, std::vector<Fault>& places, Of& of) {
    const std::size_t dot = name.find('.');
    const auto found = device(name.substr(0, dot));
    if (!found) return false;
    fault.device = *found;
    of = Of::device;
    if (dot != std::string_view::npos) {
      const std::string_view part = name.substr(dot + 1);
      of = peek() == word_of(Kind::oversleep).word ? Of::executor : Of::module;
      std::vector<std::string_view> known;
      const model::Device& model = cell_.devices[*found];
      if (of == Of::executor) {
        for (const auto& executor : model.executors) known.emplace_back(executor.name);
      } else {
        for (const auto& module : model.modules) known.emplace_back(module.name);
      }
      const auto one = std::find(known.begin(), known.end(), part);
      if (one == known.end()) {
        wrong("device " + model.name + " has no " + (of == Of::executor ? "executor " : "module ") +
                  in_quotes(part),
              known.empty() ? std::string{"it has no "} + (of == Of::executor ? "executors" : "modules")
                            : suggestion(part, known));
        return false;
      }
      fault.place = static_cast<std::uint32_t>(one - known.begin());
    }
    places.push_back(fault);
    return true;
  }

  bool connections(std::string_view name, Fault fault, std::vector<Fault>& places) {
    bool within = false;
    std::vector<std::string> outputs;
    for (std::uint32_t i = 0; i < cell_.connections.size(); ++i) {
      const model::Connection& connection = cell_.connections[i];
      if (!connection.from.given()) continue;
      outputs.push_back(model::to_text(connection.from));
      if (outputs.back() != name) continue;
      within |= !crosses(connection);
      if (!crosses(connection)) continue;
      fault.place = i;
      places.push_back(fault);
    }
    if (!places.empty()) return true;
    if (within) {
      wrong(in_quotes(name) + " is only connected within its device, where no sample is lost or late",
            "name an output that another device reads");
      return false;
    }
    const std::vector<std::string_view> known{outputs.begin(), outputs.end()};
    wrong("no connection begins at " + in_quotes(name),
          known.empty() ? "the cell has no connections" : suggestion(name, known));
    return false;
  }

  bool what(Of of, std::vector<Fault>& places) {
    std::string_view given = next();
    std::vector<std::string_view> known;
    for (const Word& word : kFaultWords) {
      if (word.of != of) continue;
      const std::vector<std::string_view> parts = split(word.word);
      known.push_back(word.word);
      if (given != parts.front()) continue;
      if (parts.size() > 1 && next() != parts[1]) {
        wrong("'" + std::string{parts[1]} + "' is missing after '" + std::string{given} + "'",
              "write, for example, " + std::string{word.example});
        return false;
      }
      for (Fault& fault : places) fault.kind = word.kind;
      if (may_name_hook(word.kind) && peek() == "in") return hook(places.front());
      return amount(word, places);
    }
    wrong(given.empty() ? "the line does not name a fault" : "there is no such fault: " + in_quotes(given),
          suggestion(given, known));
    return false;
  }

  bool hook(Fault& fault) {
    next();
    const std::string_view given = next();
    std::vector<std::string_view> known;
    for (const auto& [name, doing] : kHooks) {
      known.push_back(name);
      if (name == given) fault.hook = doing;
    }
    if (fault.hook == Doing::run) {
      wrong(given.empty() ? "there is no hook after 'in'" : "there is no hook " + in_quotes(given),
            suggestion(given, known));
      return false;
    }
    const model::Device& device = cell_.devices[fault.device];
    const model::Module& module = device.modules[fault.place];
    if (module.type == model::ModuleType::thread) return true;
    wrong("module " + device.name + "." + module.name + " is a program, and a program has no hooks",
          "remove 'in " + std::string{given} + "'");
    return false;
  }

  bool amount(const Word& word, std::vector<Fault>& places) {
    if (word.amount == Amount::duration) {
      const auto by = duration();
      const bool may_be_negative = word.kind == Kind::clock_step;
      if (!by || (*by <= Nanoseconds{0} && !may_be_negative)) {
        wrong("there is no time after '" + std::string{word.word} + "'",
              "write, for example, " + std::string{word.example});
        return false;
      }
      for (Fault& fault : places) fault.by = *by;
    }
    if (word.amount == Amount::count) {
      const std::string_view number = next();
      std::uint64_t count = 0;
      const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), count);
      if (number.empty() || error != std::errc{} || end != number.data() + number.size() || count == 0) {
        wrong("there is no number above 0 after '" + std::string{word.word} + "'",
              "write, for example, " + std::string{word.example});
        return false;
      }
      for (Fault& fault : places) fault.count = count;
    }
    return true;
  }

  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
  std::string where_;
  const model::Cell& cell_;
  std::optional<Problem> problem_;
};

}  // namespace

std::string to_text(const Fault& fault, const model::Cell& cell) {
  const Word& word = word_of(fault.kind);
  const model::Device& device = cell.devices[fault.device];
  // to_text() of a time would round the time.
  const auto exact = [](Nanoseconds time) {
    return time.count() % 1000 == 0 ? fmt::format("{} us", time.count() / 1000)
                                    : fmt::format("{} ns", time.count());
  };
  std::string line = "at " + exact(fault.at) + " ";
  switch (word.of) {
    case Of::module:
      line += device.name + "." + device.modules[fault.place].name;
      break;
    case Of::executor:
      line += device.name + "." + device.executors[fault.place].name;
      break;
    case Of::device:
      line += device.name;
      break;
    case Of::devices:
      line += "link " + device.name + " " + cell.devices[fault.place].name;
      break;
    case Of::connection:
      line += "connection " + model::to_text(cell.connections[fault.place].from);
      break;
  }
  line += " " + std::string{word.word};
  for (const auto& [name, doing] : kHooks) {
    if (doing == fault.hook) line += " in " + std::string{name};
  }
  if (word.amount == Amount::duration) line += " " + exact(fault.by);
  if (word.amount == Amount::count) line += " " + std::to_string(fault.count);
  return line;
}

Result<std::vector<Fault>> parse_script(std::string_view text, const std::string& file,
                                        const model::Cell& cell) {
  std::vector<Fault> faults;
  Problems problems;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find('#'));
    if (split(line).empty()) continue;
    auto read = Line{line, place(file, number), cell}.read();
    if (read)
      faults.insert(faults.end(), read->begin(), read->end());
    else
      problems.push_back(read.problems().front());
  }
  if (!problems.empty()) return problems;
  return faults;
}

std::string script_help() {
  std::string text;
  for (const Word& word : kFaultWords)
    text += fmt::format("  at 1.5 s {:<40} {}\n", word.example, word.means);
  text += fmt::format("  at 1.5 s {:<40} {}\n", "robot.servo fail in recover",
                      "crash, fail and hang may name a hook of a thread module");
  return text;
}

std::vector<Fault> draw_faults(const model::Cell& cell, Draws& draws, Nanoseconds length, double per_second) {
  const double expected = per_second * static_cast<double>(length.count()) / 1e9;
  const auto number =
      static_cast<std::uint64_t>(expected) + (draws.chance(expected - std::floor(expected)) ? 1 : 0);
  std::vector<std::uint32_t> crossing;
  for (std::uint32_t i = 0; i < cell.connections.size(); ++i) {
    if (crosses(cell.connections[i])) crossing.push_back(i);
  }
  using std::chrono::microseconds;
  std::vector<Fault> faults;
  while (faults.size() < number) {
    Fault fault{.kind = static_cast<Kind>(draws.below(kFaultKinds)),
                .at = draws.between(Nanoseconds{0}, length),
                .device = static_cast<std::uint32_t>(draws.below(cell.devices.size())),
                .place = 0,
                .by = draws.between(Nanoseconds{microseconds{20}}, Nanoseconds{microseconds{20'000}}),
                .count = draws.below(4) + 1};
    const model::Device& device = cell.devices[fault.device];
    const Word& word = word_of(fault.kind);
    std::size_t places = 1;
    if (word.of == Of::module) places = device.modules.size();
    if (word.of == Of::executor) places = device.executors.size();
    if (word.of == Of::devices) places = cell.devices.size();
    if (word.of == Of::connection) places = crossing.size();
    if (places == 0) continue;
    fault.place = static_cast<std::uint32_t>(draws.below(places));
    if (word.of == Of::devices && fault.place == fault.device) {
      if (cell.devices.size() == 1) continue;
      fault.place = (fault.device + 1) % static_cast<std::uint32_t>(cell.devices.size());
    }
    if (word.of == Of::connection) {
      fault.place = crossing[fault.place];
      fault.device = 0;  // the connection determines the device
    }
    if (word.of == Of::device) fault.place = 0;
    if (may_name_hook(fault.kind) && device.modules[fault.place].type == model::ModuleType::thread &&
        draws.chance(0.5)) {
      fault.hook = kHooks.at(draws.below(kHooks.size())).second;
    }
    if (fault.kind == Kind::cut) fault.by *= 10;
    if (fault.kind == Kind::clock_step && draws.chance(0.5)) fault.by = -fault.by;
    if (word.amount != Amount::duration) fault.by = Nanoseconds{0};
    if (word.amount != Amount::count) fault.count = 0;
    faults.push_back(fault);
  }
  std::stable_sort(faults.begin(), faults.end(), [](const Fault& a, const Fault& b) { return a.at < b.at; });
  return faults;
}

}  // namespace takt::simulation
