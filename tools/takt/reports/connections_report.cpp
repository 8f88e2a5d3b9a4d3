#include "reports/connections_report.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace takt::tool {

namespace {

using model::Connection;

std::string own_topic(const Connection& connection) {
  return connection.topic + (connection.domain ? fmt::format(" in domain {}", *connection.domain) : "");
}

/// A column of the table of connections. `of` returns the text for a connection, which may be empty.
struct TableColumn {
  const char* name;
  std::string (*of)(const Connection&);
};

const TableColumn kColumns[] = {
    {"from", [](const Connection& c) { return end_text(c.from); }},
    {"to", [](const Connection& c) { return end_text(c.to); }},
    {"kind", kind_text},
    {"reliability", [](const Connection& c) { return std::string{model::to_text(c.reliability)}; }},
    {"deadline", [](const Connection& c) { return c.deadline ? to_text(*c.deadline) : ""; }},
    {"stale", [](const Connection& c) { return c.deadline ? std::string{model::to_text(c.stale)} : ""; }},
    {"lifespan", [](const Connection& c) { return c.lifespan ? to_text(*c.lifespan) : ""; }},
    {"topic", [](const Connection& c) { return c.topic.empty() ? "" : own_topic(c); }},
};

/// The rows of the table of connections, without the columns that are empty in all rows.
std::vector<Page::Words> connection_rows(const std::vector<Connection>& connections, std::size_t shown,
                                         const std::map<std::size_t, std::string>& states) {
  std::vector<Page::Words> rows(1 + shown);
  for (const TableColumn& column : kColumns) {
    Page::Words words;
    for (std::size_t i = 0; i < shown; ++i) words.push_back(column.of(connections[i]));
    if (std::all_of(words.begin(), words.end(), [](const auto& word) { return word.empty(); })) continue;
    rows[0].emplace_back(column.name);
    for (std::size_t i = 0; i < shown; ++i) rows[i + 1].push_back(words[i].empty() ? "-" : words[i]);
  }
  if (states.empty()) return rows;
  rows[0].emplace_back("now");
  for (std::size_t i = 0; i < shown; ++i) {
    const auto state = states.find(i);
    rows[i + 1].push_back(state == states.end() ? "-" : state->second);
  }
  return rows;
}

/// The modules of a cell, by "device.module".
std::map<std::string, const model::Module*> modules_of(const model::Cell& cell) {
  std::map<std::string, const model::Module*> modules;
  for (const model::Device& device : cell.devices) {
    for (const model::Module& module : device.modules) modules[device.name + "." + module.name] = &module;
  }
  return modules;
}

/// The connections on which the reader gets a stale value at least once between two writes: the value in the
/// reader's last run before a write is at least as old as the writer's period minus the reader's period,
/// whatever the phases of the modules are.
std::vector<std::string> stale_by_design(const model::Cell& cell) {
  const auto modules = modules_of(cell);
  const auto period_of = [&](const model::Endpoint& end) {
    const auto found = modules.find(end.device + "." + end.module);
    const bool periodic = found != modules.end() && found->second->operation == model::Operation::periodic;
    return periodic ? found->second->period : std::nullopt;
  };
  std::vector<std::string> stale;
  for (const Connection& connection : cell.connections) {
    if (!connection.deadline) continue;
    const auto written = period_of(connection.from);
    const auto read = period_of(connection.to);
    if (!written || !read || *written - *read <= *connection.deadline) continue;
    stale.push_back(
        fmt::format("{}, whose writer runs only every {}", end_text(connection.to), to_text(*written)));
  }
  return stale;
}

/// The readers of an output that has a safe value in the descriptor, if they never get this safe value.
std::vector<std::string> without_safe_value(const model::Cell& cell) {
  const auto modules = modules_of(cell);
  std::vector<std::string> without;
  for (const Connection& connection : cell.connections) {
    const auto found = modules.find(connection.from.device + "." + connection.from.module);
    if (found == modules.end()) continue;
    const auto& safe = found->second->safe;
    if (std::none_of(safe.begin(), safe.end(),
                     [&](const model::SafeValue& value) { return value.name == connection.from.port; })) {
      continue;
    }
    if (!connection.to.given())
      without.push_back("other programs, on the topic " + connection.topic);
    else if (connection.kind == model::ConnectionKind::queue)
      without.push_back(end_text(connection.to) + ", whose connection is a queue");
  }
  return without;
}

}  // namespace

std::string end_text(const model::Endpoint& end) { return end.given() ? to_text(end) : "other programs"; }

std::string kind_text(const Connection& connection) {
  if (connection.carries != model::Carries::samples) return model::to_text(connection.carries);
  if (connection.kind == model::ConnectionKind::latest) return model::to_text(connection.kind);
  return fmt::format("queue of {}", connection.depth);
}

std::string described(const Connection& connection) {
  std::string text = kind_text(connection) + ", " + model::to_text(connection.reliability);
  if (connection.deadline) {
    text += fmt::format(", deadline {}, {} when stale", to_text(*connection.deadline),
                        model::to_text(connection.stale));
  }
  if (connection.lifespan) text += ", lifespan " + to_text(*connection.lifespan);
  if (!connection.topic.empty()) text += ", topic " + own_topic(connection);
  return text;
}

bool is_on_network(const model::Cell& cell) {
  const auto outside = [](const Connection& connection) { return !connection.topic.empty(); };
  return cell.devices.size() > 1 || cell.domain_given ||
         cell.discovery.kind != model::Discovery::Kind::multicast ||
         std::any_of(cell.connections.begin(), cell.connections.end(), outside);
}

std::string network_text(const model::Cell& cell) {
  const model::Discovery& discovery = cell.discovery;
  std::string text = fmt::format("domain {}, discovery by {}", cell.domain, model::to_text(discovery.kind));
  if (discovery.kind == model::Discovery::Kind::peers)
    text += ": " + fmt::format("{}", fmt::join(discovery.peers, " "));
  if (discovery.kind == model::Discovery::Kind::server) text += " " + discovery.server;
  if (!cell.server_device.empty()) text += ", which the node of " + cell.server_device + " starts";
  return text;
}

std::string operation_text(const model::Module& module) {
  std::string text = model::to_text(module.operation);
  if (module.period) text += ", every " + to_text(*module.period);
  if (module.deadline) text += ", deadline " + to_text(*module.deadline);
  if (module.dispatch == model::Dispatch::immediate) text += ", immediate";
  if (module.interarrival) text += ", interarrival " + to_text(*module.interarrival);
  return text;
}

void connections_text(Page& page, const model::Cell& cell, const std::map<std::size_t, std::string>& states) {
  if (cell.connections.empty()) return;
  page.blank();
  page.line(0, page.bold("connections"));
  const std::size_t shown = std::min(cell.connections.size(), kConnectionRows);
  const std::vector<Page::Words> rows = connection_rows(cell.connections, shown, states);
  if (page.fits(2, rows)) {
    page.table(2, rows);
  } else {
    for (std::size_t i = 0; i < shown; ++i) {
      const Connection& connection = cell.connections[i];
      page.sentence(2, end_text(connection.from) + " -> " + end_text(connection.to));
      page.sentence(4, described(connection));
      if (const auto state = states.find(i); state != states.end()) page.sentence(4, state->second);
    }
  }
  if (shown < cell.connections.size()) {
    page.line(
        2, fmt::format("... and {} more; takt graph --json lists them all", cell.connections.size() - shown));
  }
  const auto warn = [&page](const char* what, const std::vector<std::string>& of) {
    if (of.empty()) return;
    page.line(2, page.warning(what));
    const std::size_t named = std::min(of.size(), Page::kNamed);
    for (std::size_t i = 0; i < named; ++i) page.sentence(4, of[i]);
    if (named < of.size()) page.line(4, fmt::format("and {} more", of.size() - named));
  };
  warn("inputs that go stale between two writes, because the deadline is too short:", stale_by_design(cell));
  warn("readers that never get the safe value that the descriptor gives for the output:",
       without_safe_value(cell));
}

}  // namespace takt::tool
