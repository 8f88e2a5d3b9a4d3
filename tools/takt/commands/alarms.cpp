// takt alarms and takt acknowledge: list the faults that need somebody, and acknowledge them.
#include <nlohmann/json.hpp>

#include <takt/client/alarms.hpp>
#include <takt/client/connection.hpp>
#include <takt/model/json.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/target.hpp"
#include "reports/log_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

int list_alarms(bool as_json, const client::Network& network) {
  const auto client = client::connect(network);
  if (!client) return refuse(client.problems());
  const client::AllAlarms all = client::read_alarms(*client->sender);
  const std::string text = as_json ? model::json_text({{"alarms", model::to_json(all.alarms)}}) + "\n"
                           : all.alarms.empty() && all.problems.empty()
                               ? "no alarms\n"
                               : alarms_text(all.alarms, terminal_style());
  if (!print(text)) return 1;
  complain(all.problems);
  return all.problems.empty() ? 0 : 1;
}

int acknowledge(const std::string& text, const std::string& note, const client::Network& network) {
  const auto target = target_of(text);
  if (!target) return refuse(target.problems());
  const auto client = connect_to_device(network, target->device, target->module);
  if (!client) return refuse(client.problems());
  const auto alarms = client::acknowledge(*client->sender, target->device, target->module, note);
  if (!alarms) return refuse(alarms.problems());
  std::string lines;
  for (const model::Alarm& alarm : *alarms) {
    lines += alarm.device + (alarm.module.empty() ? "" : "." + alarm.module) + ": " +
             model::to_text(alarm.kind) + " is acknowledged\n";
  }
  return print(lines) ? 0 : 1;
}

}  // namespace

void add_alarms(CLI::App& app, Chosen& chosen) {
  auto network = std::make_shared<client::Network>();
  auto as_json = std::make_shared<bool>(false);
  auto* list = app.add_subcommand(
      "alarms", "List the alarms: the faults that nobody has acknowledged, or whose cause still exists");
  list->add_flag("--json", *as_json, "print one JSON object");
  add_network_options(*list, *network);
  list->callback([=, &chosen] { chosen = [=] { return list_alarms(*as_json, *network); }; });

  auto target = std::make_shared<std::string>();
  auto note = std::make_shared<std::string>();
  auto* command = app.add_subcommand(
      "acknowledge", "Acknowledge the alarms of a module, or of a device and all its modules");
  command->add_option("TARGET", *target, "DEVICE.MODULE, or DEVICE for the device and all its modules")
      ->required();
  command->add_option("--note", *note, "a note for the fault record, of at most 255 bytes")
      ->type_name("TEXT");
  add_network_options(*command, *network);
  command->callback([=, &chosen] { chosen = [=] { return acknowledge(*target, *note, *network); }; });
}

}  // namespace takt::tool
