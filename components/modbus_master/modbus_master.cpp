// A process module in C++: the master of a Modbus TCP device. It has a port for each point of its map.
#include <takt/process.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <basic.hpp>

#include "../common/modbus_ports.hpp"
#include "exchange.hpp"

TAKT_TEXT("Master (client) of a Modbus TCP device: its coils, inputs and registers become ports.");

namespace {

takt::Property<std::string> map{
    "map", "", {.text = "The points, one per line, for example: lamp out coil 0."}};
takt::Property<std::string> host{"host", "127.0.0.1", {.text = "Address of the device."}};
takt::Property<std::int64_t> port{"port", 502, {.min = 1, .max = 65535, .text = "TCP port of the device."}};
takt::Property<std::int64_t> unit{
    "unit",
    255,
    {.min = 0, .max = 255, .text = "Unit number of a device behind a gateway; 255: no gateway."}};
takt::Property<double> cycle{
    "cycle", 0.02, {.unit = "s", .min = 0.001, .max = 60, .text = "Time from one exchange to the next."}};
takt::Property<double> timeout{"timeout",
                               0.3,
                               {.unit = "s",
                                .min = 0.01,
                                .max = 5,
                                .text = "Limit for a connection attempt, and for each whole answer."}};
takt::Property<double> backoff{
    "backoff",
    2,
    {.unit = "s", .min = 0.1, .max = 60, .text = "Maximum time between two attempts to connect."}};
takt::Property<double> watchdog{
    "watchdog",
    1,
    {.unit = "s",
     .min = 0.05,
     .max = 60,
     .text = "If the body has not run for this long, outputs take their safe values."}};

takt::OutPort<basic::Flag> connected{"connected", {.text = "The last exchange succeeded completely."}};
takt::OutPort<basic::Count> exchanges{"exchanges",
                                      {.text = "Number of exchanges that succeeded completely."}};
takt::OutPort<basic::Count> failures{"failures", {.text = "Number of failed requests and connections."}};

// The exchange lives until the process ends. At the end of the process, it waits for the exchange thread, but
// at most for kEndLimit, because the node does not wait for the process much longer.
modbus::Exchange* exchange = nullptr;
constexpr modbus::Seconds kEndLimit{0.9};

void make_safe() { exchange->end(kEndLimit); }

modbus::Settings settings_from_properties() {
  modbus::Settings settings;
  settings.host = host.value();
  if (settings.host.empty()) {
    std::fprintf(stderr,
                 "property 'host' is empty; write the device's address, as in 10.0.0.7 or press.plant\n");
    std::exit(1);
  }
  settings.port = static_cast<int>(port.value());
  settings.unit = static_cast<int>(unit.value());
  settings.cycle = modbus::Seconds{cycle.value()};
  settings.timeout = modbus::Seconds{timeout.value()};
  settings.backoff = modbus::Seconds{backoff.value()};
  settings.watchdog = modbus::Seconds{watchdog.value()};
  return settings;
}

}  // namespace

int main() {
  modbus::Settings settings = settings_from_properties();
  const std::vector<modbus::Point> points = modbus::points_or_end(map.value());
  // Both vectors are indexed like the points. An element is empty if its point has the other direction.
  std::vector<std::unique_ptr<modbus::PointInput>> to_device(points.size());
  std::vector<std::unique_ptr<modbus::PointOutput>> from_device(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].out)
      to_device[i] = std::make_unique<modbus::PointInput>(points[i]);
    else
      from_device[i] = std::make_unique<modbus::PointOutput>(points[i]);
  }
  initPeriodExe();
  // The watchdog waits for at least three periods, so that a body with a long period does not trigger it.
  settings.watchdog =
      std::max(settings.watchdog, modbus::Seconds{3e-9 * static_cast<double>(takt_period_ns())});

  const std::string prefix = settings.host + ":" + std::to_string(settings.port);
  exchange = new modbus::Exchange{points, settings, [prefix](const std::string& what) {
                                    std::fprintf(stderr, "%s: %s\n", prefix.c_str(), what.c_str());
                                  }};
  std::thread{[] { exchange->work(); }}.detach();
  std::atexit(make_safe);

  modbus::Outputs outputs;
  std::vector<std::uint32_t> seen(points.size());
  basic::Flag is_connected;
  basic::Count count;
  while (true) {
    waitPeriod();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (to_device[i] && to_device[i]->read(outputs.value[i])) outputs.known[i] = true;
    }
    exchange->outputs.writing() = outputs;
    exchange->outputs.publish();

    exchange->image.take();
    const modbus::Image& image = exchange->image.taken();
    for (std::size_t i = 0; i < points.size(); ++i) {
      // Write a port only if the device's value was read since the last write. So a value that is no longer
      // read becomes stale, if the connection has a deadline.
      if (!from_device[i] || std::exchange(seen[i], image.reads[i]) == image.reads[i]) continue;
      from_device[i]->write(image.value[i]);
    }
    is_connected.value(image.connected);
    connected.write(is_connected);
    count.value(image.exchanges);
    exchanges.write(count);
    count.value(image.failures);
    failures.write(count);
  }
}
