// A process module in C++: a Modbus TCP device. Its ports are the points of the property `map`, which is the
// one of its master: what a master reads follows ports, what it writes appears on ports.
#include <takt/process.hpp>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <basic.hpp>

#include "../common/argument.h"
#include "../common/modbus_ports.hpp"
#include "server.hpp"

namespace {

takt::OutPort<basic::Count> clients{"clients", {.text = "Masters that are connected."}};
takt::OutPort<basic::Count> requests{"requests", {.text = "That were answered, refusals too."}};

}  // namespace

int main(int argc, char* argv[]) {
  modbus::Server::Settings settings;
  settings.address = argument_text(argc, argv, "bind", "127.0.0.1");
  settings.port = argument_whole(argc, argv, "port", 502, 1, 65535);
  settings.watchdog = modbus::Server::Seconds{argument_number(argc, argv, "watchdog", 0, 0, 3600)};
  const std::vector<modbus::Point> points = modbus::points_or_end(argument_text(argc, argv, "map", nullptr));
  // By the place of their point; the ones of the other direction are empty.
  std::vector<std::unique_ptr<modbus::PointInput>> from_cell(points.size());
  std::vector<std::unique_ptr<modbus::PointOutput>> to_cell(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].out)
      to_cell[i] = std::make_unique<modbus::PointOutput>(points[i]);
    else
      from_cell[i] = std::make_unique<modbus::PointInput>(points[i]);
  }
  initPeriodExe();

  // Until the process has ended, whoever ends it: its thread is not waited for.
  static auto* const server = new modbus::Server{
      points, settings, [](const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); }};
  if (const std::string problem = server->listen(); !problem.empty()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
    return 1;
  }
  std::thread{[] { server->work(); }}.detach();

  modbus::Inputs inputs;
  std::vector<std::uint32_t> seen(points.size());
  basic::Count count;
  while (true) {
    waitPeriod();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (from_cell[i] && from_cell[i]->read(inputs.value[i])) inputs.known[i] = true;
    }
    server->inputs.writing() = inputs;
    server->inputs.publish();

    server->image.take();
    const modbus::Image& image = server->image.taken();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!to_cell[i] || std::exchange(seen[i], image.writes[i]) == image.writes[i]) continue;
      to_cell[i]->write(image.value[i]);
    }
    count.value(image.clients);
    clients.write(count);
    count.value(image.requests);
    requests.write(count);
  }
}
