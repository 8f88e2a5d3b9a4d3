#include <takt/client/tap.hpp>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

std::string path_of(const PortName& name) { return name.device + "." + name.module + "." + name.port; }

/// Returns the topic that the answer names, and the type of its samples. Throws an exception if the answer
/// has no topic or no valid type.
std::pair<std::string, model::Type> topic_in(const json& answer) {
  auto type = model::parse_type(answer.at("type").get<std::string>());
  auto topic = answer.at("topic").get<std::string>();
  if (!type || topic.empty()) throw std::invalid_argument{"no topic"};
  return {std::move(topic), std::move(*type)};
}

/// Adds the names DEVICE.MODULE.SERVICE of a module's services.
void add_services(std::set<std::string>& services, const std::string& module,
                  const std::vector<model::Port>& ports) {
  for (const model::Port& port : ports) {
    if (port.role == model::Role::service || port.role == model::Role::handler)
      services.insert(module + "." + model::name_of_service(port));
  }
}

}  // namespace

Result<CommandRequest> tap_request(const std::string& port, Nanoseconds every) {
  const auto name = parse_port(port);
  if (!name) return fail(in_quotes(port) + " is not a port name", "write DEVICE.MODULE.PORT");
  return CommandRequest{.kind = COMMAND_TAP,
                        .device = name->device,
                        .module = name->module,
                        .property = name->port,
                        .value = every > Nanoseconds{0} ? std::to_string(every.count()) : "",
                        .time_ns = os::wall_ns() + Nanoseconds{kTapped}.count()};
}

Result<dds::Flow> tapped(Operator& sender, const std::string& port, Nanoseconds every) {
  const auto request = tap_request(port, every);
  if (!request) return request.problems();
  const auto answer = accepted(sender.send(*request));
  if (!answer) return answer.problems();
  return flow_in(answer->data, port);
}

Result<dds::Flow> flow_in(const std::string& data, const std::string& port) {
  bool is_service = false;
  dds::Flow flow{.topic = {}, .type = {}, .quality = {.depth = 64, .deadline = {}, .lifespan = {}}};
  const auto read = read_answer(port.substr(0, port.find('.')), data, [&](const json& answer) {
    is_service = answer.contains("reply");
    if (is_service) return;
    std::tie(flow.topic, flow.type) = topic_in(answer);
    flow.quality.reliable = answer.at("reliable").get<bool>();
  });
  if (!read) return read.problems();
  if (is_service) {
    return fail(port + " is a service", "call it with takt call " + port +
                                            "; to see its requests and replies, use takt echo with the "
                                            "client's ports NAME/request and NAME/reply");
  }
  return flow;
}

Result<ServiceTopics> opened_service(Operator& sender, const PortName& name, Nanoseconds open_for) {
  const auto answer = accepted(sender.send({.kind = COMMAND_TAP,
                                            .device = name.device,
                                            .module = name.module,
                                            .property = name.port,
                                            .time_ns = os::wall_ns() + open_for.count()}));
  if (answer) {
    auto topics = service_in(answer->data, name);
    if (!topics) return topics.problems();
    if (*topics) return std::move(**topics);
  }
  const auto description = accepted(
      sender.send({.kind = COMMAND_DESCRIBE, .device = name.device, .limit = std::chrono::seconds{10}}));
  const auto modules =
      description ? described_modules(name.device, description->data) : description.problems();
  if (modules) {
    std::optional<std::vector<model::Port>> ports_of_module;
    std::set<std::string> others;
    for (const json& module : *modules) {
      auto ports = model::parse_ports(model::json_text({{"ports", module.at("ports")}}));
      if (!ports) continue;
      if (module.at("name") == name.module)
        ports_of_module = std::move(*ports);
      else
        add_services(others, name.device + "." + module.at("name").get<std::string>(), *ports);
    }
    if (ports_of_module) {
      if (auto problem = not_a_service(name, *ports_of_module, others)) return std::move(*problem);
    }
  }
  // Here the module has the service, or its ports are not known. So report the reason that the device gave.
  return answer ? Problems{fail(path_of(name) + " is a port, not a service")} : answer.problems();
}

Result<std::optional<ServiceTopics>> service_in(const std::string& data, const PortName& name) {
  std::optional<ServiceTopics> topics;
  const auto read = read_answer(name.device, data, [&topics](const json& answer) {
    auto [topic, type] = topic_in(answer);
    if (!answer.contains("reply")) return;
    auto [reply_topic, reply_type] = topic_in(answer.at("reply"));
    topics = {std::move(topic), std::move(reply_topic), std::move(type), std::move(reply_type)};
  });
  if (!read) return read.problems();
  return topics;
}

std::optional<Problem> not_a_service(const PortName& name, const std::vector<model::Port>& ports,
                                     const std::set<std::string>& others) {
  const std::string module = name.device + "." + name.module;
  for (const model::Port& port : ports) {
    if (port.role != model::Role::plain && model::name_of_service(port) == name.port) return std::nullopt;
  }
  std::set<std::string> services;
  add_services(services, module, ports);
  const auto list = [](const std::set<std::string>& all) {
    return std::vector<std::string_view>{all.begin(), all.end()};
  };
  const std::string there = !services.empty() ? "services of the module: " + one_of(list(services))
                            : others.empty()  ? "no module of device " + name.device + " has one"
                                              : "services of other modules: " + one_of(list(others));
  const std::string none = "module " + module + " has no services";
  if (name.port.empty()) return fail(services.empty() ? none : module + " is a module, not a service", there);
  const std::string text = path_of(name);
  const auto port = std::find_if(ports.begin(), ports.end(),
                                 [&](const model::Port& each) { return each.name == name.port; });
  if (port == ports.end()) {
    return fail("module " + module + " has no service " + in_quotes(name.port),
                services.empty() ? there : suggestion(text, list(services)));
  }
  const bool output = port->direction == model::Direction::out;
  return fail(text + " is an " + (output ? "output" : "input") + " port, not a service",
              (output ? "show its samples with takt echo " + text + "; " : "") +
                  (services.empty() ? none + "; " : "") + there);
}

}  // namespace takt::client
