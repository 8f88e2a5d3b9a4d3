#include <takt/model/cell.hpp>

#include <algorithm>

#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>

namespace takt::model {

const char* to_text(ModuleType type) { return type == ModuleType::thread ? "thread" : "process"; }

const char* to_text(Operation operation) {
  switch (operation) {
    case Operation::periodic:
      return "periodic";
    case Operation::sporadic:
      return "sporadic";
    case Operation::non_real:
      return "non-real";
  }
  return "?";
}

const char* to_text(Wakeup wakeup) {
  switch (wakeup) {
    case Wakeup::sleep:
      return "sleep";
    case Wakeup::hybrid:
      return "hybrid";
    case Wakeup::spin:
      return "spin";
  }
  return "?";
}

const char* to_text(GiveUp then) {
  switch (then) {
    case GiveUp::destruct:
      return "destruct";
    case GiveUp::stop_device:
      return "stop-device";
    case GiveUp::stop_cell:
      return "stop-cell";
  }
  return "?";
}
const char* to_text(ConnectionKind kind) { return kind == ConnectionKind::latest ? "latest" : "queue"; }
const char* to_text(Stale stale) { return stale == Stale::hold ? "hold" : "error"; }
const char* to_text(Reliability reliability) {
  return reliability == Reliability::best_effort ? "best-effort" : "reliable";
}
const char* to_text(Dispatch dispatch) { return dispatch == Dispatch::row ? "row" : "immediate"; }
const char* to_text(Overrun overrun) {
  switch (overrun) {
    case Overrun::skip:
      return "skip";
    case Overrun::catch_up:
      return "catch-up";
    case Overrun::error:
      return "error";
    case Overrun::stop_device:
      return "stop-device";
    case Overrun::stop_cell:
      return "stop-cell";
  }
  return "?";
}

const char* to_text(Offsets offsets) { return offsets == Offsets::given ? "given" : "auto"; }
const char* to_text(Timing timing) { return timing == Timing::direct ? "direct" : "let"; }

const char* to_text(Carries carries) {
  switch (carries) {
    case Carries::samples:
      return "samples";
    case Carries::requests:
      return "requests";
    case Carries::replies:
      return "replies";
  }
  return "?";
}

const char* to_text(Miss miss) { return miss == Miss::count ? "count" : "error"; }

const char* to_text(Discovery::Kind kind) {
  switch (kind) {
    case Discovery::Kind::multicast:
      return "multicast";
    case Discovery::Kind::peers:
      return "peers";
    case Discovery::Kind::server:
      return "server";
  }
  return "?";
}

std::string to_text(const Endpoint& end) {
  std::string text = end.device + "." + end.module + "." + end.port;
  while (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

std::string topic_of(const Cell& cell, const Connection& connection) {
  if (!connection.topic.empty()) return connection.topic;
  const Endpoint& writer = connection.carries == Carries::replies ? connection.to : connection.from;
  return std::string{kOwnTopics} + cell.name + "/" + writer.device + "/" + writer.module + "/" + writer.port;
}

namespace {
/// Returns the executor of a periodic module; null for sporadic and non-real modules.
const Executor* executor_of_periodic(const Device& device, const Module& module) {
  if (module.operation != Operation::periodic) return nullptr;
  const auto executor =
      std::find_if(device.executors.begin(), device.executors.end(),
                   [&module](const Executor& candidate) { return candidate.name == module.executor; });
  return executor == device.executors.end() ? nullptr : &*executor;
}
}  // namespace

void connect_services(Cell& cell) {
  const auto half = [](Endpoint end, const char* port) {
    end.port += port;
    return end;
  };
  for (const Service& service : cell.services) {
    Connection connection{.from = half(service.client, kRequestPort),
                          .to = half(service.server, kRequestPort),
                          .kind = ConnectionKind::queue,
                          .depth = kServiceDepth,
                          .reliability = Reliability::reliable,
                          .deadline = {},
                          .lifespan = {},
                          .topic = {},
                          .domain = {},
                          .carries = Carries::requests,
                          .line = service.line};
    cell.connections.push_back(connection);
    connection.from = half(service.server, kReplyPort);
    connection.to = half(service.client, kReplyPort);
    connection.carries = Carries::replies;
    cell.connections.push_back(std::move(connection));
  }
}

std::vector<std::string> device_names(const Cell& cell) {
  std::vector<std::string> names;
  for (const Device& device : cell.devices) names.push_back(device.name);
  return names;
}

OverrunContract contract_of(const Device& device, const Module& module) {
  if (module.overrun) return *module.overrun;
  const Executor* executor = executor_of_periodic(device, module);
  return executor == nullptr ? OverrunContract{} : executor->overrun;
}

Nanoseconds hang_limit(const Module& module) {
  using namespace std::chrono_literals;
  if (module.hang) return *module.hang;
  if (module.budget && module.type == ModuleType::thread) {
    const int budgets = std::max(10, module.tolerance.times.value_or(0));
    return std::max<Nanoseconds>(20ms, std::min<Nanoseconds>(*module.budget, 1h) * budgets);
  }
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(Nanoseconds{0});
  return 1s + 10 * std::min<Nanoseconds>(own, 6s);
}

bool stops_cell(const Device& device) {
  return std::any_of(device.modules.begin(), device.modules.end(), [&device](const Module& module) {
    return module.recovery.then == GiveUp::stop_cell ||
           contract_of(device, module).what == Overrun::stop_cell;
  });
}

Timing timing_of(const Device& device, const Module& module) {
  const Executor* executor = executor_of_periodic(device, module);
  return executor == nullptr ? Timing::direct : executor->timing;
}

bool has_log(const Module& module) {
  return module.type == ModuleType::thread || module.operation != Operation::non_real;
}

Line line_of_file(const Module& module) {
  return module.lines.filename.given() ? module.lines.filename : module.line;
}

std::string in_one_line(const std::vector<std::string>& arguments) {
  std::string line;
  for (const std::string& argument : arguments) {
    const bool plain = !argument.empty() && argument.find_first_of(" \t\r\n'") == std::string::npos;
    line += (line.empty() ? "" : " ") + (plain ? argument : in_quotes(argument));
  }
  return line;
}

Result<std::string> given_property(const Module& module, const std::string& name) {
  std::vector<std::string_view> names;
  for (const PropertyValue& property : module.properties) {
    if (property.name == name) return property.value;
    names.emplace_back(property.name);
  }
  if (has_log(module)) names.emplace_back(kLogLevelProperty);
  return fail("the descriptor does not set property " + in_quotes(name) + " of module " + module.name,
              names.empty() ? "it sets no properties of this module" : suggestion(name, names));
}

void give_property(Module& module, const std::string& name, const std::string& value) {
  for (PropertyValue& property : module.properties) {
    if (property.name != name) continue;
    property.value = value;
    return;
  }
  module.properties.push_back({.name = name, .value = value});
}

}  // namespace takt::model
