#include <takt/simulation/injection.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <takt/core/words.hpp>

namespace takt::simulation {

namespace {

using Kind = Injection::Kind;

using Of = Injection::Target;
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
    Word{Kind::cut, Of::link, "cut for", Amount::duration, "link robot line cut for 500 ms",
         "nothing passes between the two devices; one may be 'operator'"},
    Word{Kind::lose, Of::connection, "lose", Amount::count, "connection robot.arm.state lose 3",
         "the output's next three samples to other devices are lost"},
    Word{Kind::delay, Of::connection, "late", Amount::duration, "connection robot.arm.state late 5 ms",
         "the output's next sample to other devices takes 5 ms longer"},
    Word{Kind::down, Of::device, "down for", Amount::duration, "robot down for 2 s",
         "the device loses its power, and its node starts again with --resume"},
    Word{Kind::pause, Of::device, "paused for", Amount::duration, "robot paused for 2 s",
         "the node of the device stands still, but its modules run on"},
    Word{Kind::twin, Of::device, "twin", Amount::none, "robot twin",
         "a second node with this device name starts on another machine"},
    Word{Kind::deploy, Of::cell, "deploy", Amount::none, "deploy", "as with takt deploy"},
    Word{Kind::update, Of::cell, "update", Amount::none, "update",
         "as with takt deploy --update, with the descriptor given with --update"},
    Word{Kind::undeploy, Of::cell, "undeploy", Amount::none, "undeploy", "as with takt undeploy"},
    Word{Kind::finish, Of::module, "finish", Amount::none, "robot.servo finish",
         "the module's next run is its last one, because the module has finished"},
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
/// The number of kinds of faults that draw_injections() can draw. These kinds come first in kFaultWords.
constexpr std::uint64_t kFaultKinds = static_cast<std::uint64_t>(Kind::delay) + 1;

using channel::Doing;

/// The calls of a thread module in which a script may inject a fault.
constexpr std::array<std::pair<std::string_view, Doing>, 6> kHooks{{{"load", Doing::load},
                                                                    {"initialize", Doing::initialize},
                                                                    {"start", Doing::start},
                                                                    {"error", Doing::error},
                                                                    {"recover", Doing::recover},
                                                                    {"destruct", Doing::destruct}}};

/// The name of the operator in a script.
constexpr std::string_view kOperator = "operator";

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

  Result<std::vector<Injection>> read() {
    Injection injection;
    if (next() != "at")
      return wrong("the line does not begin with 'at'", "write, for example, at 1.5 s robot.servo late 3 ms");
    const std::string_view number = peek();
    const auto at = duration();
    if (!at || *at < Nanoseconds{0}) {
      const bool digits =
          !number.empty() && number.find_first_not_of(".0123456789") == std::string_view::npos;
      return wrong(digits ? "the time " + in_quotes(number) + " after 'at' has no unit"
                          : "there is no time since T0 after 'at'",
                   "write, for example, at 1.5 s or at 20 ms");
    }
    injection.at = *at;

    std::vector<Injection> targets;
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
      of = Of::link;
      injection.device = *a;
      injection.target = *b;
      targets.push_back(injection);
    } else if (peek() == "connection") {
      next();
      of = Of::connection;
      if (!connections(next(), injection, targets)) return *problem_;
    } else if (is_action(peek()) && (words_.size() == at_ + 1 || !is_device(peek()))) {
      of = Of::cell;
      targets.push_back(injection);
    } else if (!target(next(), injection, targets, of)) {
      return *problem_;
    }

    if (!what(of, targets)) return *problem_;
    if (!peek().empty())
      return wrong("the line continues after the fault: " + in_quotes(peek()), "write one fault per line");
    return targets;
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

  /// Returns the index of a device, or the number of devices for the operator.
  std::optional<std::uint32_t> device(std::string_view name) {
    std::vector<std::string_view> known;
    for (std::uint32_t i = 0; i < cell_.devices.size(); ++i) {
      if (cell_.devices[i].name == name) return i;
      known.emplace_back(cell_.devices[i].name);
    }
    if (name == kOperator) return static_cast<std::uint32_t>(cell_.devices.size());
    const bool is_alone = at_ == words_.size() && name.find('.') == std::string_view::npos;
    for (const Word& word : kFaultWords) {
      if (is_alone && word.of == Of::cell) known.push_back(word.word);
    }
    wrong(std::string{"there is no "} + (is_alone ? "action " : "device ") + in_quotes(name),
          suggestion(name, known));
    return std::nullopt;
  }

  /// Reads DEVICE, DEVICE.MODULE or DEVICE.EXECUTOR, depending on the fault.
  bool target(std::string_view name, Injection& injection, std::vector<Injection>& targets, Of& of) {
    const std::size_t dot = name.find('.');
    const auto found = device(name.substr(0, dot));
    if (!found) return false;
    injection.device = *found;
    const bool may_be_operator = dot == std::string_view::npos && (peek() == "down" || peek() == "paused");
    if (*found == cell_.devices.size() && !may_be_operator) {
      wrong("the operator can only be down or paused", "write, for example, operator paused for 2 s");
      return false;
    }
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
      injection.target = static_cast<std::uint32_t>(one - known.begin());
    }
    targets.push_back(injection);
    return true;
  }

  [[nodiscard]] bool is_device(std::string_view name) const {
    return std::any_of(cell_.devices.begin(), cell_.devices.end(),
                       [name](const model::Device& one) { return one.name == name; });
  }
  static bool is_action(std::string_view word) {
    return std::any_of(kFaultWords.begin(), kFaultWords.end(),
                       [word](const Word& one) { return one.of == Of::cell && one.word == word; });
  }

  bool connections(std::string_view name, Injection injection, std::vector<Injection>& targets) {
    bool within = false;
    std::vector<std::string> outputs;
    for (std::uint32_t i = 0; i < cell_.connections.size(); ++i) {
      const model::Connection& connection = cell_.connections[i];
      if (!connection.from.given()) continue;
      outputs.push_back(model::to_text(connection.from));
      if (outputs.back() != name) continue;
      within |= !crosses(connection);
      if (!crosses(connection)) continue;
      injection.target = i;
      targets.push_back(injection);
    }
    if (!targets.empty()) return true;
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

  bool what(Of of, std::vector<Injection>& targets) {
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
      for (Injection& injection : targets) injection.kind = word.kind;
      if (may_name_hook(word.kind) && peek() == "in") return hook(targets.front());
      return amount(word, targets);
    }
    wrong(given.empty() ? "the line does not name a fault" : "there is no such fault: " + in_quotes(given),
          suggestion(given, known));
    return false;
  }

  bool hook(Injection& injection) {
    next();
    const std::string_view given = next();
    std::vector<std::string_view> known;
    for (const auto& [name, doing] : kHooks) {
      known.push_back(name);
      if (name == given) injection.hook = doing;
    }
    if (injection.hook == Doing::run) {
      wrong(given.empty() ? "there is no hook after 'in'" : "there is no hook " + in_quotes(given),
            suggestion(given, known));
      return false;
    }
    const model::Device& device = cell_.devices[injection.device];
    const model::Module& module = device.modules[injection.target];
    if (module.type == model::ModuleType::thread) return true;
    wrong("module " + device.name + "." + module.name + " is a program, and a program has no hooks",
          "remove 'in " + std::string{given} + "'");
    return false;
  }

  bool amount(const Word& word, std::vector<Injection>& targets) {
    if (word.amount == Amount::duration) {
      const auto by = duration();
      const bool may_be_negative = word.kind == Kind::clock_step;
      if (!by || (*by <= Nanoseconds{0} && !may_be_negative)) {
        wrong("there is no time after '" + std::string{word.word} + "'",
              "write, for example, " + std::string{word.example});
        return false;
      }
      for (Injection& injection : targets) injection.by = *by;
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
      for (Injection& injection : targets) injection.count = count;
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

Injection::Target target_of(Kind kind) { return word_of(kind).of; }

std::string to_text(const Injection& injection, const model::Cell& cell) {
  const Word& word = word_of(injection.kind);
  const auto name = [&cell](std::uint32_t device) {
    return device < cell.devices.size() ? cell.devices[device].name : std::string{kOperator};
  };
  // Prints a time exactly; takt::to_text() would round it.
  const auto exact = [](Nanoseconds time) {
    return time.count() % 1000 == 0 ? fmt::format("{} us", time.count() / 1000)
                                    : fmt::format("{} ns", time.count());
  };
  std::string line = "at " + exact(injection.at) + " ";
  switch (word.of) {
    case Of::module:
      line +=
          name(injection.device) + "." + cell.devices[injection.device].modules[injection.target].name + " ";
      break;
    case Of::executor:
      line += name(injection.device) + "." + cell.devices[injection.device].executors[injection.target].name +
              " ";
      break;
    case Of::device:
      line += name(injection.device) + " ";
      break;
    case Of::link:
      line += "link " + name(injection.device) + " " + name(injection.target) + " ";
      break;
    case Of::connection:
      line += "connection " + model::to_text(cell.connections[injection.target].from) + " ";
      break;
    case Of::cell:
      break;
  }
  line += std::string{word.word};
  for (const auto& [hook, doing] : kHooks) {
    if (doing == injection.hook) line += " in " + std::string{hook};
  }
  if (word.amount == Amount::duration) line += " " + exact(injection.by);
  if (word.amount == Amount::count) line += " " + std::to_string(injection.count);
  return line;
}

Result<std::vector<Injection>> parse_script(std::string_view text, const std::string& file,
                                            const model::Cell& cell) {
  std::vector<Injection> injections;
  Problems problems;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find('#'));
    if (split(line).empty()) continue;
    auto read = Line{line, location(file, number), cell}.read();
    if (read)
      injections.insert(injections.end(), read->begin(), read->end());
    else
      problems.push_back(read.problems().front());
  }
  if (!problems.empty()) return problems;
  return injections;
}

std::string script_help() {
  std::string text;
  for (const Word& word : kFaultWords)
    text += fmt::format("  at 1.5 s {:<40} {}\n", word.example, word.means);
  text += fmt::format("  at 1.5 s {:<40} {}\n", "robot.servo fail in recover",
                      "crash, fail and hang may name a hook of a thread module");
  text += fmt::format("  at 1.5 s {:<40} {}\n", "operator paused for 2 s",
                      "the program takt stands still; it may also be down: it then ends its action");
  return text;
}

std::vector<Injection> draw_injections(const model::Cell& cell, Draws& draws, Nanoseconds length,
                                       double per_second) {
  const double expected = per_second * static_cast<double>(length.count()) / 1e9;
  const auto number =
      static_cast<std::uint64_t>(expected) + (draws.chance(expected - std::floor(expected)) ? 1 : 0);
  std::vector<std::uint32_t> crossing;
  for (std::uint32_t i = 0; i < cell.connections.size(); ++i) {
    if (crosses(cell.connections[i])) crossing.push_back(i);
  }
  using std::chrono::microseconds;
  std::vector<Injection> injections;
  while (injections.size() < number) {
    Injection injection{.kind = static_cast<Kind>(draws.below(kFaultKinds)),
                        .at = draws.between(Nanoseconds{0}, length),
                        .device = static_cast<std::uint32_t>(draws.below(cell.devices.size())),
                        .target = 0,
                        .by = draws.between(Nanoseconds{microseconds{20}}, Nanoseconds{microseconds{20'000}}),
                        .count = draws.below(4) + 1};
    const model::Device& device = cell.devices[injection.device];
    const Word& word = word_of(injection.kind);
    std::size_t targets = 1;
    if (word.of == Of::module) targets = device.modules.size();
    if (word.of == Of::executor) targets = device.executors.size();
    if (word.of == Of::link) targets = cell.devices.size();
    if (word.of == Of::connection) targets = crossing.size();
    if (targets == 0) continue;
    injection.target = static_cast<std::uint32_t>(draws.below(targets));
    if (word.of == Of::link && injection.target == injection.device) {
      if (cell.devices.size() == 1) continue;
      injection.target = (injection.device + 1) % static_cast<std::uint32_t>(cell.devices.size());
    }
    if (word.of == Of::connection) {
      injection.target = crossing[injection.target];
      injection.device = 0;  // a fault of a connection has no device
    }
    if (word.of == Of::device) injection.target = 0;
    if (may_name_hook(injection.kind) && device.modules[injection.target].type == model::ModuleType::thread &&
        draws.chance(0.5)) {
      injection.hook = kHooks.at(draws.below(kHooks.size())).second;
    }
    if (injection.kind == Kind::cut) injection.by *= 10;
    if (injection.kind == Kind::clock_step && draws.chance(0.5)) injection.by = -injection.by;
    if (word.amount != Amount::duration) injection.by = Nanoseconds{0};
    if (word.amount != Amount::count) injection.count = 0;
    injections.push_back(injection);
  }
  std::stable_sort(injections.begin(), injections.end(),
                   [](const Injection& a, const Injection& b) { return a.at < b.at; });
  return injections;
}

}  // namespace takt::simulation
