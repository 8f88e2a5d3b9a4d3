// The commands that an operator sends to a module: takt start, stop, recover, reset, destruct and initialize,
// takt restart, takt get and set, and takt swap.
#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/target.hpp"
#include "reports/properties_report.hpp"
#include "reports/run_report.hpp"
#include "terminal/terminal.hpp"
#include "web/property_values.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

struct ModuleCommand {
  CommandKind kind;
  const char* name;
  const char* text;
};

constexpr std::array kModuleCommands{
    ModuleCommand{COMMAND_INITIALIZE, "initialize", "Initialize a module that is in IDLE"},
    ModuleCommand{COMMAND_START, "start", "Start a module: it is EXECUTING whenever its device runs"},
    ModuleCommand{COMMAND_STOP, "stop", "Stop a module: it leaves its table and stays ready, in START"},
    ModuleCommand{COMMAND_RECOVER, "recover",
                  "Recover a module in RECOVER now, without waiting for the next automatic attempt"},
    ModuleCommand{COMMAND_RESET, "reset",
                  "Load the component of a module in DESTRUCT again; the module is then in IDLE"},
    ModuleCommand{COMMAND_DESTRUCT, "destruct", "End a module; it does not run again until it is reset"},
};

/// Returns a state as text. After a stop, the state is START, so the text adds that the module is stopped.
std::string state_after(CommandKind command, const std::string& state) {
  return state_text(state, command == COMMAND_STOP && state == to_text(STATE_START));
}

int send(const ModuleCommand& command, const std::string& text, const client::Network& network) {
  const auto target = target_of(text);
  if (!target) return refuse(target.problems());
  const auto client = connect_to_device(network, target->device, target->module);
  if (!client) return refuse(client.problems());
  const auto answer = client->sender->send({.kind = command.kind,
                                            .device = target->device,
                                            .module = target->module,
                                            .limit = std::chrono::seconds{20}});
  if (!answer) return refuse(answer.problems());

  // If the target is a device that carried out or tried the command, its answer has one outcome for each of
  // its modules.
  if (target->module.empty() && answer->data.starts_with("[")) {
    std::string lines;
    const auto read =
        client::read_answer(target->device, answer->data, [&](const nlohmann::ordered_json& all) {
          for (const auto& each : all) {
            const auto why = each.at("text").get<std::string>();
            const auto state = each.at("state").get<std::string>();
            lines += fmt::format(
                "{}.{}: {}\n", target->device, each.at("module").get<std::string>(),
                why.empty() ? state_after(command.kind, state) : state + " (" + on_one_line(why) + ")");
          }
        });
    if (!read) return refuse(read.problems());
    if (!print(lines)) return 1;
  } else if (answer->head.code() == REPLY_OK) {
    const std::string state = state_after(command.kind, to_text(answer->head.state()));
    return print(fmt::format("{}: {}\n", text, state)) ? 0 : 1;
  }
  if (answer->head.code() == REPLY_OK) return 0;
  return refuse(client::problems_of(*answer));
}

// Returns the state of a module; empty if the device has no such module.
Result<std::string> state_of(client::Operator& sender, const Target& target) {
  const auto answer = client::accepted(
      sender.send({.kind = COMMAND_REPORT, .device = target.device, .limit = std::chrono::seconds{10}}));
  if (!answer) return answer.problems();
  std::string state;
  const auto read =
      client::read_answer(target.device, answer->data, [&](const nlohmann::ordered_json& report) {
        for (const auto& module : report.at("modules")) {
          if (module.at("name") == target.module) state = module.at("state").get<std::string>();
        }
      });
  if (!read) return read.problems();
  return state;
}

// Ends a module if it has not ended, and starts it from the beginning.
int restart(const std::string& text, const client::Network& network) {
  const auto target = module_of(text);
  if (!target) return refuse(target.problems());
  const auto client = connect_to_device(network, target->device, target->module);
  if (!client) return refuse(client.problems());
  const auto command = [&](CommandKind kind) {
    return client->sender->send({.kind = kind,
                                 .device = target->device,
                                 .module = target->module,
                                 .limit = std::chrono::seconds{20}});
  };
  const auto state = state_of(*client->sender, *target);
  if (!state) return refuse(state.problems());
  const std::vector<CommandKind> steps = steps_of_restart(*state);
  auto answer = client::accepted(command(steps[0]));
  for (std::size_t i = 1; answer && i < steps.size(); ++i) answer = client::accepted(command(steps[i]));
  if (!answer) return refuse(answer.problems());
  return print(fmt::format("{}: {}\n", text, to_text(answer->head.state()))) ? 0 : 1;
}

// Returns all properties of a module, with their values.
Result<nlohmann::ordered_json> properties_of(client::Operator& sender, const Target& target) {
  const auto answer = client::accepted(
      sender.send({.kind = COMMAND_DESCRIBE, .device = target.device, .limit = std::chrono::seconds{10}}));
  if (!answer) return answer.problems();
  const auto modules = client::described_modules(target.device, answer->data);
  if (!modules) return modules.problems();
  const auto module = std::find_if(modules->begin(), modules->end(),
                                   [&](const Json& one) { return one.at("name") == target.module; });
  if (module == modules->end()) {
    std::vector<std::string> names;
    for (const Json& one : *modules) names.push_back(one.at("name").get<std::string>());
    return fail("device " + target.device + " has no module " + in_quotes(target.module),
                suggestion(target.module, {names.begin(), names.end()}));
  }
  Json list = module->at("properties");
  add_property_values(list, sender, target.device, target.module);
  return list;
}

/// Like target_of(), for a command about a module. If `text` is only a module's name, the error message is
/// that of the search for this device, which suggests DEVICE.MODULE.
Result<Target> find_target(const std::string& text, const char* then, const client::Network& network) {
  auto target = target_of(text, then);
  if (target || text.empty() || text.find('.') != std::string::npos) return target;
  const auto client = connect_to_device(network, text, "");
  if (!client) return client.problems();
  return target;
}

int property(const std::string& text, const std::string& name, const std::optional<std::string>& value,
             const client::Network& network) {
  const auto target = find_target(text, "property", network);
  if (!target) return refuse(target.problems());
  const auto client = connect_to_device(network, target->device, target->module);
  if (!client) return refuse(client.problems());
  const auto answer = client::accepted(client->sender->send({.kind = value ? COMMAND_SET : COMMAND_GET,
                                                             .device = target->device,
                                                             .module = target->module,
                                                             .property = name,
                                                             .value = value.value_or("")}));
  if (!answer) return refuse(answer.problems());
  return print(on_one_line(answer->head.value().to_string()) + "\n") ? 0 : 1;
}

// Prints all properties of a module, with their values.
int properties(const std::string& text, bool as_json, const client::Network& network) {
  const auto target = find_target(text, "property, or DEVICE.MODULE alone to list all of them", network);
  if (!target) return refuse(target.problems());
  const auto client = connect_to_device(network, target->device, target->module);
  if (!client) return refuse(client.problems());
  const auto list = properties_of(*client->sender, *target);
  if (!list) return refuse(list.problems());
  return print(as_json ? model::json_text({{"module", text}, {"properties", *list}}) + "\n"
                       : properties_text(*list, terminal_style()))
             ? 0
             : 1;
}

int swap(const std::string& text, const std::string& file, const client::Network& network) {
  if (text.ends_with(".so"))
    return refuse({fail(in_quotes(text) + " is a file, but the module comes first",
                        "write takt swap " + file + " " + text)});
  const auto target = find_target(text, "file", network);
  if (!target) return refuse(target.problems());
  const auto client = connect_to_device(network, target->device, target->module);
  if (!client) return refuse(client.problems());
  const auto answer = client::accepted(client->sender->send({.kind = COMMAND_SWAP,
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

/// Returns what is missing in a call of `takt set` without a VALUE.
std::string missing_in_set(const std::string& module, const std::vector<std::string>& given) {
  const std::string property = given.empty() ? "" : given[0];
  const std::size_t dot = module.find('.');
  const std::size_t second = dot == std::string::npos ? dot : module.find('.', dot + 1);
  if (second != std::string::npos && !property.empty())
    return fmt::format("'{}' is not the name of a module; write takt set {} {} {}", module,
                       module.substr(0, second), module.substr(second + 1), property);
  if (dot == std::string::npos)
    return fmt::format("'{}' is not the name of a module; write takt set DEVICE.MODULE {}", module,
                       property.empty() ? "PROPERTY VALUE" : module + " " + property);
  return fmt::format("the {} missing; write takt set {} {} VALUE",
                     property.empty() ? "property and its value are" : "value is", module,
                     property.empty() ? "PROPERTY" : property);
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

void add_restart(CLI::App& app, Chosen& chosen) {
  auto target = std::make_shared<std::string>();
  auto network = std::make_shared<client::Network>();
  auto* command = app.add_subcommand(
      "restart",
      "Start a module from the beginning, whatever its state: end, reset, initialize and start it");
  command->add_option("MODULE", *target, "DEVICE.MODULE")->required();
  add_network_options(*command, *network);
  command->callback([=, &chosen] { chosen = [=] { return restart(*target, *network); }; });
}

void add_swap(CLI::App& app, Chosen& chosen) {
  auto target = std::make_shared<std::string>();
  auto file = std::make_shared<std::string>();
  auto network = std::make_shared<client::Network>();
  auto* command = app.add_subcommand(
      "swap",
      "Replace the component of a running periodic thread module by another version, between two rows");
  command->add_option("MODULE", *target, "DEVICE.MODULE")->required();
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
             : app.add_subcommand("get",
                                  "Print the current value of a property, or all properties of a module");
    auto as_json = std::make_shared<bool>(false);
    auto* module = command->add_option("MODULE", *target, "DEVICE.MODULE")->required();
    if (sets) {
      // A check of the name comes before the message that VALUE is missing.
      command->add_option("PROPERTY", *name, "the name of the property, as `takt get` lists it")
          ->required()
          ->check(CLI::Validator{[](const std::string& given) -> std::string {
                                   const std::size_t at = given.find('=');
                                   if (at == std::string::npos) return "";
                                   return fmt::format(
                                       "'{}' is not the name of a property; write the name and the value as "
                                       "two arguments: {} {}",
                                       given, given.substr(0, at), given.substr(at + 1));
                                 },
                                 ""});
      command->add_option("VALUE", *value, "the new value")->required();
      // The validator of the first argument runs before CLI11 reports only that VALUE is required.
      module->check(CLI::Validator{
          [command](const std::string& given) -> std::string {
            const auto property = command->get_option("PROPERTY")->results();
            const bool pair = !property.empty() && property[0].find('=') != std::string::npos;
            if (command->count("VALUE") == 0 && !pair && command->get_help_ptr()->empty())
              throw CLI::ParseError{missing_in_set(given, property), CLI::ExitCodes::RequiredError};
            return "";
          },
          ""});
    } else {
      auto* property =
          command->add_option("PROPERTY", *name, "the name of the property; without it, all are listed");
      command->add_flag("--json", *as_json, "list all properties as JSON")->excludes(property);
    }
    add_network_options(*command, *network);
    command->callback([=, &chosen] {
      chosen = [=] {
        if (!sets && name->empty()) return properties(*target, *as_json, *network);
        return property(*target, *name, sets ? std::optional{*value} : std::nullopt, *network);
      };
    });
  }
}

}  // namespace takt::tool
