// takt graph: prints or draws the devices, modules and connections of a cell; with --live, also the states of
// the running cell.
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/status.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>
#include <takt/os/output_file.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/ranges.hpp"
#include "commands/network_options.hpp"
#include "reports/graph_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct GraphOptions {
  std::string file;
  std::string svg;  ///< the file for the drawing; if empty, print lists instead
  bool json = false;
  bool live = false;
  client::Network network;
};

Result<CellHealth> ask(const model::Cell& cell, const client::Network& network) {
  const auto client = client::connect(network, &cell);
  if (!client) return client.problems();
  const auto status = client::status(*client->sender);
  if (!status) return status.problems();
  CellHealth health = health_of(cell, *status);
  if (health.devices.empty()) {
    return fail("cell " + cell.name + " is not running on domain " + std::to_string(client->domain) +
                    ", where the running cell is " + status->at("cell").get<std::string>(),
                "deploy the cell, or leave out --live");
  }
  return health;
}

int graph(const GraphOptions& options) {
  // Do not use load(), because a drawing needs neither the components nor valid tables.
  auto cell = descriptor::load(options.file);
  if (!cell) {
    complain(cell.problems());
    return 1;
  }
  if (const auto domain = client::domain_of(options.network, &*cell); domain) cell->domain = *domain;
  CellHealth health;
  if (options.live) {
    auto answer = ask(*cell, options.network);
    if (!answer) {
      complain(answer.problems());
      return 1;
    }
    health = std::move(*answer);
  }
  if (!options.svg.empty()) {
    if (const auto written = os::write_output(options.svg, graph_svg(*cell, health)); !written) {
      complain(written.problems());
      return 1;
    }
    if (!options.json) return 0;
  }
  const std::string text = options.json ? model::json_text(graph_json(*cell, health)) + "\n"
                                        : graph_text(*cell, health, terminal_style());
  return print(text) ? 0 : 1;
}

}  // namespace

void add_graph(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<GraphOptions>();
  auto* command = app.add_subcommand(
      "graph", "Print or draw the devices and modules of a cell, and the connections between their ports");
  command->add_option("FILE", options->file, "a cell, or a module.xml")->required();
  command->add_option("--svg", options->svg, "write a drawing (SVG) to this file")->type_name("OUT")->check(svg_file());
  command->add_flag("--json", options->json, "print one JSON object");
  command->add_flag("--live", options->live,
                    "add the states of the running cell and the health of each connection");
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return graph(*options); }; });
}

}  // namespace takt::tool
