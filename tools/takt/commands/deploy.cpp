// takt deploy and takt undeploy: deploy a cell to the nodes on the network, or take it down.
#include <cstdio>

#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/deploy.hpp>
#include <takt/client/update.hpp>
#include <takt/os/clock.hpp>
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

void print_progress(const std::string& text) { std::fprintf(stderr, "%s ...\n", text.c_str()); }

int update_cell(client::Operator& asker, const Loaded& loaded, const std::function<bool()>& cancelled) {
  bool printed = true;
  const auto updated = client::update(asker, loaded.cell, loaded.text,
                                      {.progress = print_progress,
                                       .differs =
                                           [&printed](const std::vector<std::string>& lines) {
                                             for (const std::string& line : lines)
                                               printed = print(line + "\n") && printed;
                                           },
                                       .cancelled = cancelled});
  if (updated.problems.empty()) return print(updated.outcome + "\n") && printed ? 0 : 1;
  complain(updated.problems);
  std::fprintf(stderr, "%s\n", updated.outcome.c_str());
  return 1;
}

int deploy(const DeployOptions& options) {
  const auto loaded = load_remote(options.file);
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  const auto signals =
      os::SignalQueue::of_requests_to_end();  // comes before other threads, which inherit the blocked signals
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
  if (options.update) return update_cell(*client->asker, *loaded, cancelled);
  BringUpProgress bring_up{*client, loaded->cell};
  const auto deployed = client::deploy(*client->asker, loaded->cell, loaded->text,
                                       {.require_real_time = options.require_real_time,
                                        .process_ids = {},
                                        .progress = [&](const std::string& text) { bring_up.print(text); },
                                        .cancelled =
                                            [&] {
                                              bring_up.refresh();
                                              return cancelled();
                                            }});
  bring_up.end(deployed.ok());
  if (!deployed) {
    complain(deployed.problems());
    std::fprintf(stderr, "cell %s was not deployed; the devices are unchanged\n", loaded->cell.name.c_str());
    return 1;
  }
  // The cell runs from this instant on. Wait for it before the output says that the cell runs, because the
  // operator may then send commands.
  os::sleep_until(os::instant_of_wall(deployed->t0_ns));
  std::string names;
  for (const model::Device& device : loaded->cell.devices) names += (names.empty() ? "" : ", ") + device.name;
  return print("cell " + loaded->cell.name + " runs on " + names + "\n") ? 0 : 1;
}

struct UndeployOptions {
  std::string cell;
  client::Network network;
};

int undeploy(const UndeployOptions& options) {
  const auto client = client::connect(options.network);
  if (!client) {
    complain(client.problems());
    return 1;
  }
  const auto devices = client::devices_of(*client->asker, options.cell);
  if (!devices) {
    complain(devices.problems());
    return 1;
  }
  Problems problems;
  std::string names;
  for (const std::string& device : devices->lost) {
    problems.push_back(
        {"device " + device, "is lost and did not receive the command",
         "when you start its node again, leave out --resume; otherwise the device resumes the cell"});
  }
  for (const auto& one : client::undeploy(*client->asker, {.names = devices->names})) {
    problems.insert(problems.end(), one.problems.begin(), one.problems.end());
    if (one.problems.empty()) names += (names.empty() ? "" : ", ") + one.device;
    for (const std::string& failure : one.failures)
      std::fprintf(stderr, "failed earlier: %s\n", failure.c_str());
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
  command->add_option("CELL", options->cell, "the cell's name")->required();
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return undeploy(*options); }; });
}

}  // namespace takt::tool
