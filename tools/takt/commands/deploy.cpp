// takt deploy and takt undeploy: deploy a cell to the nodes on the network, or take it down.
#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/deploy.hpp>
#include <takt/client/update.hpp>
#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/findings.hpp>
#include <takt/os/signals.hpp>

#include "commands/bring_up.hpp"
#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct DeployOptions {
  std::string file;
  client::Network network;
  bool require_real_time = false;
  bool update = false;
};

void print_progress(const std::string& text) { tell(text + " ..."); }

int update_cell(client::Operator& sender, const Loaded& loaded, const std::function<bool()>& cancelled) {
  bool printed = true;
  const auto updated = client::update(sender, loaded.cell, loaded.text,
                                      {.progress = print_progress,
                                       .differs =
                                           [&printed](const std::vector<std::string>& lines) {
                                             for (const std::string& line : lines)
                                               printed = print(line + "\n") && printed;
                                           },
                                       .cancelled = cancelled});
  warn(updated.failed_modules);
  if (updated.problems.empty()) return print(updated.outcome + "\n") && printed ? 0 : 1;
  complain(updated.problems);
  tell(updated.outcome);
  return 1;
}

int deploy(const DeployOptions& options) {
  const auto loaded = load_remote(options.file);
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  // Block the signals before any thread starts, because new threads inherit the set of blocked signals.
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (const std::string note = client::domain_note(options.network, loaded->cell); !note.empty()) tell(note);
  const auto client = client::connect(options.network, &loaded->cell);
  if (!signals || !client) {
    complain(signals ? client.problems() : signals.problems());
    return 1;
  }
  bool asked_to_end = false;
  const auto cancelled = [&] {
    while (signals->next()) asked_to_end = true;
    return asked_to_end;
  };
  if (options.update) return update_cell(*client->sender, *loaded, cancelled);
  BringUpProgress bring_up{*client, loaded->cell};
  std::vector<client::Undeployed> undone;
  const auto deployed = client::deploy(*client->sender, loaded->cell, loaded->text,
                                       {.require_real_time = options.require_real_time,
                                        .process_ids = {},
                                        .progress = [&](const std::string& text) { bring_up.print(text); },
                                        .cancelled =
                                            [&] {
                                              bring_up.refresh();
                                              return cancelled();
                                            },
                                        .undone = &undone});
  bring_up.end(deployed.ok());
  if (!deployed) {
    complain(deployed.problems());
    std::string unknown;
    std::size_t many = 0;
    for (const client::Undeployed& one : undone) {
      if (one.problems.empty()) continue;
      unknown += (unknown.empty() ? "" : ", ") + one.device;
      ++many;
    }
    const std::string state = unknown.empty()
                                  ? "the devices are unchanged"
                                  : unknown + (many == 1 ? " has" : " have") +
                                        " not confirmed this; takt status shows whether the cell runs there";
    tell("cell " + loaded->cell.name + " was not deployed; " + state);
    return 1;
  }
  warn(deployed->failed_modules);
  std::string names;
  for (const model::Device& device : loaded->cell.devices) names += (names.empty() ? "" : ", ") + device.name;
  return print("cell " + loaded->cell.name + " runs on " + names + "\n") ? 0 : 1;
}

struct UndeployOptions {
  std::string cell;
  client::Network network;
};

int undeploy(const UndeployOptions& options) {
  if (!model::is_valid_name(options.cell) && std::filesystem::is_regular_file(options.cell)) {
    const auto cell = descriptor::load(options.cell);
    return refuse(
        {fail(in_quotes(options.cell) + " is a file, but the name of a cell is needed",
              cell ? "write takt undeploy " + cell->name : "takt status shows the names of the cells")});
  }
  const auto client = client::connect(options.network);
  if (!client) {
    complain(client.problems());
    return 1;
  }
  const auto devices = client::devices_of(*client->sender, options.cell);
  if (!devices) {
    complain(devices.problems());
    return 1;
  }
  Problems problems;
  std::string names;
  for (const std::string& device : devices->lost) {
    problems.push_back(
        {"device " + device, "it is lost and did not receive the command",
         "the other devices pass it on when the device is back, unless their nodes are restarted before"});
  }
  client::Devices all{.names = devices->names, .process_ids = {}, .deployment = devices->deployment};
  all.names.insert(all.names.end(), devices->waiting.begin(), devices->waiting.end());
  for (const auto& one : client::undeploy(*client->sender, all)) {
    problems.insert(problems.end(), one.problems.begin(), one.problems.end());
    const bool had_it = std::count(devices->names.begin(), devices->names.end(), one.device) != 0;
    if (one.problems.empty() && had_it) names += (names.empty() ? "" : ", ") + one.device;
    for (const std::string& failure : one.failures) tell("failed earlier: " + failure);
  }
  if (!problems.empty()) complain(problems);
  const bool printed = names.empty() || print("cell " + options.cell + " is undeployed from " + names + "\n");
  return problems.empty() && printed ? 0 : 1;
}

}  // namespace

void add_deploy(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<DeployOptions>();
  auto* command = app.add_subcommand(
      "deploy", "Run a cell on the nodes on the network, either on all of its devices or on none");
  command->add_option("FILE", options->file, "a cell, or a module.xml")->required();
  auto* require = command->add_flag("--require-realtime", options->require_real_time,
                                    "fail if a device's system denies real-time scheduling");
  command
      ->add_flag("--update", options->update,
                 "change a running cell to match FILE, either on all of its devices or on none")
      ->excludes(require);
  add_network_options(*command, options->network);
  command->footer(
      "--update changes modules while they run, where it can: it sets properties and swaps the components\n"
      "of periodic thread modules. If anything else differs on a device, Takt takes the device down and\n"
      "brings it up again, on the same time grid. The other devices keep running.");
  command->callback([options, &chosen] { chosen = [options] { return deploy(*options); }; });
}

void add_undeploy(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<UndeployOptions>();
  auto* command = app.add_subcommand("undeploy", "Take down a cell on all of its devices");
  command->add_option("CELL", options->cell, "the cell's name, or the id of its deployment")->required();
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return undeploy(*options); }; });
}

}  // namespace takt::tool
