// takt start, stop, recover, reset, destruct, initialize; takt get and set; takt swap: what an operator tells
// a module.
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/dds/words.hpp>
#include <takt/model/json.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct Order {
  CommandKind kind;
  const char* name;
  const char* text;
};

constexpr std::array kOrders{
    Order{COMMAND_INITIALIZE, "initialize", "Initialise a module that is in IDLE, or all of a device"},
    Order{COMMAND_START, "start", "Start a module, so that it is EXECUTING while its device runs"},
    Order{COMMAND_STOP, "stop", "Take a module out of its table; it stays ready in START"},
    Order{COMMAND_RECOVER, "recover", "Try at once to recover a module that is in RECOVER"},
    Order{COMMAND_RESET, "reset", "Load a module in DESTRUCT afresh: it is IDLE then"},
    Order{COMMAND_DESTRUCT, "destruct", "End a module; it never runs again unless it is reset"},
};

/// DEVICE or DEVICE.MODULE
struct Target {
  std::string device;
  std::string module;
};

/// `then`: what comes after a module, where it must be one; null: it may be a device too.
Result<Target> target_of(const std::string& text, const char* then = nullptr) {
  const bool module_needed = then != nullptr;
  const std::size_t dot = text.find('.');
  Target target{text.substr(0, dot), dot == std::string::npos ? "" : text.substr(dot + 1)};
  const bool right = !target.device.empty() &&
                     (dot == std::string::npos ? !module_needed : !target.module.empty()) &&
                     target.module.find('.') == std::string::npos;
  if (!right) {
    return fail("'" + text + "' names no " + (module_needed ? "module" : "device or module"),
                module_needed ? fmt::format("say DEVICE.MODULE, and the {} after a blank", then)
                              : "say DEVICE or DEVICE.MODULE");
  }
  return target;
}

int order(const Order& order, const std::string& text, const client::Network& network) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto target = target_of(text);
  if (!target) return refuse(target.problems());
  const auto client = client::connect(network);
  if (!client) return refuse(client.problems());
  const auto answer = client->asker->ask({.kind = order.kind,
                                          .device = target->device,
                                          .module = target->module,
                                          .limit = std::chrono::seconds{20}});
  if (!answer) return refuse(answer.problems());

  // A whole device answers for each of its modules.
  const auto outcomes = model::parse_json(answer->data);
  if (target->module.empty() && outcomes.is_array()) {
    std::string lines;
    for (const auto& each : outcomes) {
      const std::string why = each.value("text", "");
      lines += fmt::format("{}.{}: {}{}\n", target->device, each.value("module", ""), each.value("state", ""),
                           why.empty() ? "" : " (" + why + ")");
    }
    if (!print(lines)) return 1;
  } else if (answer->head.code() == REPLY_OK) {
    return print(fmt::format("{}: {}\n", text, to_text(answer->head.state()))) ? 0 : 1;
  }
  if (answer->head.code() == REPLY_OK) return 0;
  return refuse(client::problems_of(*answer));
}

int property(const std::string& text, const std::string& name, const std::optional<std::string>& value,
             const client::Network& network) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto target = target_of(text, "property");
  if (!target) return refuse(target.problems());
  if (value && value->size() > 255) return refuse({fail("the value is longer than 255 bytes")});
  const auto client = client::connect(network);
  if (!client) return refuse(client.problems());
  const auto answer = client::accepted(client->asker->ask({.kind = value ? COMMAND_SET : COMMAND_GET,
                                                           .device = target->device,
                                                           .module = target->module,
                                                           .property = name,
                                                           .value = value.value_or("")}));
  if (!answer) return refuse(answer.problems());
  return print(answer->head.value().to_string() + "\n") ? 0 : 1;
}

int swap(const std::string& text, const std::string& file, const client::Network& network) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto target = target_of(text, "file");
  if (!target) return refuse(target.problems());
  if (file.size() > 255) return refuse({fail("the name of the file is longer than 255 bytes")});
  const auto client = client::connect(network);
  if (!client) return refuse(client.problems());
  const auto answer = client::accepted(client->asker->ask({.kind = COMMAND_SWAP,
                                                           .device = target->device,
                                                           .module = target->module,
                                                           .value = file,
                                                           .limit = std::nullopt}));
  if (!answer) return refuse(answer.problems());
  return print(fmt::format("{}: {} {}\n", text, answer->head.value().to_string(),
                           answer->head.text().to_string()))
             ? 0
             : 1;
}

}  // namespace

void add_orders(CLI::App& app, Chosen& chosen) {
  for (const Order& each : kOrders) {
    auto target = std::make_shared<std::string>();
    auto network = std::make_shared<client::Network>();
    auto* command = app.add_subcommand(each.name, each.text);
    command->add_option("TARGET", *target, "DEVICE.MODULE, or DEVICE for all of its modules")->required();
    add_network_options(*command, *network);
    command->callback([&each, target, network, &chosen] {
      chosen = [&each, target, network] { return order(each, *target, *network); };
    });
  }
}

void add_swap(CLI::App& app, Chosen& chosen) {
  auto target = std::make_shared<std::string>();
  auto file = std::make_shared<std::string>();
  auto network = std::make_shared<client::Network>();
  auto* command = app.add_subcommand(
      "swap", "Put another version of a periodic thread module in its place while it runs, between two rows");
  command->add_option("TARGET", *target, "DEVICE.MODULE")->required();
  command->add_option("FILE", *file, "the new .so, found as at a deployment: on the device's component path")
      ->required();
  add_network_options(*command, *network);
  command->footer(
      "What the module saves is handed over. Where one of the first 10 runs fails, the version before is\n"
      "put back. The descriptor stays as it is: the next deployment, and --resume, load what it says.");
  command->callback([=, &chosen] { chosen = [=] { return swap(*target, *file, *network); }; });
}

void add_properties(CLI::App& app, Chosen& chosen) {
  for (const bool sets : {false, true}) {
    auto target = std::make_shared<std::string>();
    auto name = std::make_shared<std::string>();
    auto value = std::make_shared<std::string>();
    auto network = std::make_shared<client::Network>();
    auto* command = sets ? app.add_subcommand(
                               "set", "Set a property of a module while it runs, between two of its cycles")
                         : app.add_subcommand("get", "Print the value that a property of a module has");
    command->add_option("TARGET", *target, "DEVICE.MODULE")->required();
    command->add_option("PROPERTY", *name, "its name, as `takt describe` prints it")->required();
    if (sets) command->add_option("VALUE", *value, "the new value")->required();
    add_network_options(*command, *network);
    command->callback([=, &chosen] {
      chosen = [=] {
        return property(*target, *name, sets ? std::optional{*value} : std::nullopt, *network);
      };
    });
  }
}

}  // namespace takt::tool
