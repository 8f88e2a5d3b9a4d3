// Prints a cell as text, for tests that compare cells.
#pragma once

#include <cstdint>
#include <optional>
#include <sstream>
#include <string>

#include <takt/core/words.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// Converts a cell to text, with all its values but without line numbers.
class CellText {
 public:
  explicit CellText(const model::Cell& cell) {
    add("cell", cell.name, cell.domain, cell.domain_given, to_text(cell.discovery.kind),
        cell.discovery.server, cell.discovery.serve, cell.server_device, cell.security_required);
    for (const auto& peer : cell.discovery.peers) add("peer", peer);
    for (const auto& device : cell.devices) {
      add("device", device.name);
      for (const auto& e : device.executors)
        add("executor", e.name, e.cpu.value_or(-1), e.priority, to_text(e.wakeup));
      for (const auto& module : device.modules) add_module(module);
    }
    for (const auto& c : cell.connections) {
      add("connection", to_text(c.from), to_text(c.to), to_text(c.kind), c.depth, to_text(c.reliability),
          ns(c.deadline), ns(c.lifespan), to_text(c.stale), c.topic, c.domain.value_or(-1),
          to_text(c.carries));
    }
    for (const auto& s : cell.services) add("service", to_text(s.client), to_text(s.server));
  }
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  static std::int64_t ns(const std::optional<Nanoseconds>& time) { return time ? time->count() : -1; }
  template <class... Words>
  void add(const Words&... words) {
    ((text_ << in_quotes((std::ostringstream{} << words).str()) << ' '), ...);
    text_ << '\n';
  }
  void add_module(const model::Module& m) {
    add("module", m.name, m.filename, to_text(m.type), to_text(m.operation), ns(m.period), ns(m.deadline),
        to_text(m.miss), to_text(m.dispatch), ns(m.interarrival), m.priority, m.executor, ns(m.budget),
        m.recovery.attempts, m.recovery.backoff.count(), to_text(m.recovery.then));
    for (const auto& argument : m.arguments) add("argument", argument);
    for (const auto& p : m.properties) add("property", p.name, p.value);
  }
  std::ostringstream text_;
};

inline std::string text_of_cell(const model::Cell& cell) { return CellText{cell}.text(); }

}  // namespace takt::descriptor
