// A process module in C++: a Modbus TCP device. The module has a port for each point of the property `map`;
// its master uses the same map. Masters read the values of the input ports. The values that masters write
// appear on the output ports.
#include <takt/process.hpp>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <basic.hpp>

#include "../common/modbus_ports.hpp"
#include "server.hpp"

TAKT_TEXT("A Modbus TCP device (server): masters read its input ports and write its output ports.");

namespace {

takt::Property<std::string> map{
    "map",
    "",
    {.text = "The points, one per line, for example: lamp out coil 0. The master uses the same map."}};
takt::Property<std::string> address{
    "bind", "127.0.0.1", {.text = "Address to listen on; 0.0.0.0: all addresses."}};
takt::Property<std::int64_t> port{
    "port", 502, {.min = 1, .max = 65535, .text = "TCP port; ports below 1024 need root."}};
takt::Property<double> watchdog{
    "watchdog",
    0,
    {.unit = "s",
     .min = 0,
     .max = 3600,
     .text = "If no master writes for this long, the outputs take their safe values; 0: never."}};

takt::OutPort<basic::Count> clients{"clients", {.text = "Number of connected masters."}};
takt::OutPort<basic::Count> requests{"requests",
                                     {.text = "Number of answered requests, including rejected ones."}};

}  // namespace

int main() {
  modbus::Server::Settings settings;
  settings.address = address.value();
  settings.port = static_cast<int>(port.value());
  settings.watchdog = modbus::Server::Seconds{watchdog.value()};
  const std::vector<modbus::Point> points = modbus::points_or_end(map.value());
  // Both vectors are indexed like the points. An element is empty if its point has the other direction.
  std::vector<std::unique_ptr<modbus::PointInput>> from_cell(points.size());
  std::vector<std::unique_ptr<modbus::PointOutput>> to_cell(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].out)
      to_cell[i] = std::make_unique<modbus::PointOutput>(points[i]);
    else
      from_cell[i] = std::make_unique<modbus::PointInput>(points[i]);
  }
  initPeriodExe();

  // The server lives until the process ends, because its thread is never joined.
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
