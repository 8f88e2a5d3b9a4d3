#include <takt/model/doubts.hpp>

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include <takt/core/time.hpp>
#include <takt/core/words.hpp>

namespace takt::model {

namespace {

// Shorter times are rarely meant: waking a thread alone takes longer on most machines.
constexpr Nanoseconds kShortest = std::chrono::microseconds{10};

const Module* find_module(const Cell& cell, const Endpoint& end) {
  for (const Device& device : cell.devices) {
    if (device.name != end.device) continue;
    for (const Module& module : device.modules) {
      if (module.name == end.module) return &module;
    }
  }
  return nullptr;
}

class Doubts {
 public:
  Doubts(const Cell& cell, const CellPorts& ports) : cell_(cell), ports_(ports) {}

  Problems run() {
    for (const Device& device : cell_.devices) {
      for (const Module& module : device.modules) {
        doubt_time("deadline", module.deadline, module.lines.deadline, module);
        doubt_time("budget", module.budget, module.lines.budget, module);
      }
    }
    for (const Connection& connection : cell_.connections) {
      if (connection.carries != Carries::samples) continue;
      doubt_depth(connection);
      doubt_event_port(connection);
      doubt_deadline(connection);
    }
    return std::move(warnings_);
  }

 private:
  void warn(Line line, std::string what, std::string fix) {
    warnings_.push_back(problem_at(cell_.texts(), line, std::move(what), std::move(fix)));
  }

  void doubt_time(const char* element, const std::optional<Nanoseconds>& time, Line line,
                  const Module& module) {
    if (!time || *time >= kShortest) return;
    warn(line.given() ? line : module.line,
         std::string{"the "} + element + " of " + in_quotes(module.name) + " is only " +
             takt::to_text(*time) + ", which is less than most machines need to wake a thread",
         "write a unit if you meant one, as in 500us: a number alone is in ns");
  }

  void doubt_depth(const Connection& connection) {
    if (connection.kind != ConnectionKind::queue || connection.depth_given) return;
    warn(connection.line,
         "the queue " +
             (connection.to.given() ? "to " + to_text(connection.to) : "from " + to_text(connection.from)) +
             " has no depth, so it holds 1 sample: a new sample replaces one that was not read yet",
         "write depth=\"8\" to keep up to 8 samples, or depth=\"1\" if one is enough");
  }

  void doubt_event_port(const Connection& connection) {
    const Port* to = find_port(cell_, ports_, connection.to);
    if (to == nullptr || to->direction != Direction::event) return;
    if (connection.kind != ConnectionKind::queue) {
      warn(connection.line,
           "the connection to event port " + to_text(connection.to) +
               " holds only the latest value, so a new event replaces an event that the module has not read "
               "yet",
           "write kind=\"queue\" depth=\"8\" to keep up to 8 events");
    }
    const Module* module = find_module(cell_, connection.to);
    if (module == nullptr || module->operation != Operation::periodic) return;
    warn(connection.line,
         "event port " + to_text(connection.to) + " belongs to a periodic module, which no event releases",
         "make the module sporadic if an event should release it");
  }

  void doubt_deadline(const Connection& connection) {
    const Module* from = find_module(cell_, connection.from);
    if (!connection.deadline || from == nullptr || !from->period || *connection.deadline >= *from->period)
      return;
    warn(connection.line,
         "the values of " + to_text(connection.from) + " become stale after " +
             takt::to_text(*connection.deadline) + ", before the module writes the next one: its period is " +
             takt::to_text(*from->period),
         "write a deadline that is longer than the period");
  }

  const Cell& cell_;
  const CellPorts& ports_;
  Problems warnings_;
};

}  // namespace

Problems doubts(const Cell& cell, const CellPorts& ports) { return Doubts{cell, ports}.run(); }

}  // namespace takt::model
