// The agent of one device.
#include <CLI/CLI.hpp>

#include <takt/node/control.hpp>

int main(int argc, char** argv) {
  takt::node::NodeOptions options;
  CLI::App app{
      "The agent of one device: starts its host and its programs, watches them, and ends them in order.",
      "takt-node"};
  app.add_option("--device", options.device, "the device of the descriptor that this node runs")->required();
  app.add_option("--file", options.file, "the descriptor: a cell, or a module.xml")->required();
  app.add_flag("--require-realtime", options.require_real_time,
               "refuse to run where the system refuses real-time scheduling");
  app.add_flag("--quiet", options.quiet, "say nothing but errors");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return takt::node::run_node(options);
}
