// takt status: prints the state and statistics of every device and module on the DDS domain.
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/status.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "reports/run_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct StatusOptions {
  bool json = false;
  client::Network network;
};

int status(const StatusOptions& options) {
  const auto client = client::connect(options.network);
  if (!client) {
    complain(client.problems());
    return 1;
  }
  const auto report = client::status(*client->sender);
  if (!report) {
    complain(report.problems());
    return 1;
  }
  return print(options.json ? run_json(*report) : run_text(*report, terminal_style())) ? 0 : 1;
}

}  // namespace

void add_status(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<StatusOptions>();
  auto* command = app.add_subcommand(
      "status", "Print the state and statistics of every device and module on the DDS domain");
  command->add_flag("--json", options->json, "print one JSON object");
  add_network_options(*command, options->network);
  command->footer(kColumns);
  command->callback([options, &chosen] { chosen = [options] { return status(*options); }; });
}

}  // namespace takt::tool
