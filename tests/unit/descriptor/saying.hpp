// What a cell says as text, for tests that compare cells.
#pragma once

#include <cstdint>
#include <optional>
#include <sstream>
#include <string>

#include <takt/core/words.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// Everything that a cell says, but where it says it.
class Saying {
 public:
  explicit Saying(const model::Cell& cell) {
    say("cell", cell.name, cell.domain, cell.domain_given, to_text(cell.discovery.kind),
        cell.discovery.server, cell.discovery.serve, cell.server_device, cell.security_required);
    for (const auto& peer : cell.discovery.peers) say("peer", peer);
    for (const auto& device : cell.devices) {
      say("device", device.name);
      for (const auto& e : device.executors)
        say("executor", e.name, e.cpu.value_or(-1), e.priority, to_text(e.wakeup));
      for (const auto& module : device.modules) say_module(module);
    }
    for (const auto& c : cell.connections) {
      say("connection", to_text(c.from), to_text(c.to), to_text(c.kind), c.depth, to_text(c.reliability),
          ns(c.deadline), ns(c.lifespan), to_text(c.stale), c.topic, c.domain.value_or(-1),
          to_text(c.carries));
    }
    for (const auto& s : cell.services) say("service", to_text(s.client), to_text(s.server));
  }
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  static std::int64_t ns(const std::optional<Nanoseconds>& time) { return time ? time->count() : -1; }
  template <class... Words>
  void say(const Words&... words) {
    ((text_ << in_quotes((std::ostringstream{} << words).str()) << ' '), ...);
    text_ << '\n';
  }
  void say_module(const model::Module& m) {
    say("module", m.name, m.filename, to_text(m.type), to_text(m.operation), ns(m.period), ns(m.deadline),
        to_text(m.miss), to_text(m.dispatch), ns(m.interarrival), m.priority, m.executor, ns(m.budget),
        m.recovery.attempts, m.recovery.backoff.count(), to_text(m.recovery.then));
    for (const auto& p : m.properties) say("property", p.name, p.value);
  }
  std::ostringstream text_;
};

inline std::string said_of(const model::Cell& cell) { return Saying{cell}.text(); }

}  // namespace takt::descriptor
