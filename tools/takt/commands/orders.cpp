// The commands that an operator sends to a module: takt start, stop, recover, reset, destruct and initialize,
// takt get and set, and takt swap.
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct ModuleCommand {
  CommandKind kind;
  const char* name;
  const char* text;
};

constexpr std::array kModuleCommands{
    ModuleCommand{COMMAND_INITIALIZE, "initialize", "Initialise a module that is in IDLE"},
    ModuleCommand{COMMAND_START, "start", "Start a module: it is EXECUTING whenever its device runs"},
    ModuleCommand{COMMAND_STOP, "stop", "Stop a module: it leaves its table and stays ready, in START"},
    ModuleCommand{COMMAND_RECOVER, "recover",
                  "Recover a module in RECOVER now, without waiting for the next automatic attempt"},
    ModuleCommand{COMMAND_RESET, "reset",
                  "Load the component of a module in DESTRUCT again; the module is then in IDLE"},
    ModuleCommand{COMMAND_DESTRUCT, "destruct", "End a module; it does not run again until it is reset"},
};

/// The target of a command: DEVICE or DEVICE.MODULE.
struct Target {
  std::string device;
  std::string module;
};

/// Splits the name of a target. If the target must be a module, `then` is the name of the next argument, for
/// the error message. If the target may be a device, `then` is null.
Result<Target> target_of(const std::string& text, const char* then = nullptr) {
  const bool module_needed = then != nullptr;
  const std::size_t dot = text.find('.');
  Target target{text.substr(0, dot), dot == std::string::npos ? "" : text.substr(dot + 1)};
  const bool right = !target.device.empty() &&
                     (dot == std::string::npos ? !module_needed : !target.module.empty()) &&
                     target.module.find('.') == std::string::npos;
  if (!right) {
    return fail("'" + text + "' is not the name of a " + (module_needed ? "module" : "device or module"),
                module_needed ? fmt::format("write DEVICE.MODULE, a space and the {}", then)
                              : "write DEVICE or DEVICE.MODULE");
  }
  return target;
}

int send(const ModuleCommand& command, const std::string& text, const client::Network& network) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto target = target_of(text);
  if (!target) return refuse(target.problems());
  const auto client = client::connect(network);
  if (!client) return refuse(client.problems());
  const auto answer = client->asker->ask({.kind = command.kind,
                                          .device = target->device,
                                          .module = target->module,
                                          .limit = std::chrono::seconds{20}});
  if (!answer) return refuse(answer.problems());

  // If the target is a device, its answer has one outcome for each of its modules.
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
  if (file.size() > 255) return refuse({fail("the file name is longer than 255 bytes")});
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

void add_module_commands(CLI::App& app, Chosen& chosen) {
  for (const ModuleCommand& each : kModuleCommands) {
    auto target = std::make_shared<std::string>();
    auto network = std::make_shared<client::Network>();
    auto* command = app.add_subcommand(each.name, each.text);
    command->add_option("TARGET", *target, "DEVICE.MODULE, or DEVICE for all modules of the device")
        ->required();
    add_network_options(*command, *network);
    command->callback([&each, target, network, &chosen] {
      chosen = [&each, target, network] { return send(each, *target, *network); };
    });
  }
}

void add_swap(CLI::App& app, Chosen& chosen) {
  auto target = std::make_shared<std::string>();
  auto file = std::make_shared<std::string>();
  auto network = std::make_shared<client::Network>();
  auto* command = app.add_subcommand(
      "swap",
      "Replace the component of a running periodic thread module by another version, between two rows");
  command->add_option("TARGET", *target, "DEVICE.MODULE")->required();
  command
      ->add_option("FILE", *file, "the new .so file, in a folder on the component path of the device's node")
      ->required();
  add_network_options(*command, *network);
  command->footer(
      "The new version takes over the state that the old version has saved. If one of its first 10 runs\n"
      "fails, Takt puts the old version back. The descriptor does not change: the next deployment, and\n"
      "--resume, load the file that the descriptor names.");
  command->callback([=, &chosen] { chosen = [=] { return swap(*target, *file, *network); }; });
}

void add_properties(CLI::App& app, Chosen& chosen) {
  for (const bool sets : {false, true}) {
    auto target = std::make_shared<std::string>();
    auto name = std::make_shared<std::string>();
    auto value = std::make_shared<std::string>();
    auto network = std::make_shared<client::Network>();
    auto* command =
        sets ? app.add_subcommand("set", "Set a property of a running module, between two of its cycles")
             : app.add_subcommand("get", "Print the current value of a property of a module");
    command->add_option("TARGET", *target, "DEVICE.MODULE")->required();
    command->add_option("PROPERTY", *name, "the name of the property, as `takt describe` prints it")
        ->required();
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
