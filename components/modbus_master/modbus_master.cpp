// A process module in C++: the master of a Modbus TCP device. Its ports are the points of the property `map`.
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

#include "../common/argument.h"
#include "../common/modbus_ports.hpp"
#include "exchange.hpp"

namespace {

takt::OutPort<basic::Flag> connected{"connected", {.text = "The last exchange went well as a whole."}};
takt::OutPort<basic::Count> exchanges{"exchanges", {.text = "That went well as a whole."}};
takt::OutPort<basic::Count> failures{"failures", {.text = "Requests and connections that did not go well."}};

// Until the process has ended, whoever ends it: the thread is not waited for longer than the node waits for
// us.
modbus::Exchange* exchange = nullptr;
constexpr modbus::Seconds kEndLimit{0.9};

void make_safe() { exchange->end(kEndLimit); }

modbus::Settings settings_from(int argc, char* argv[]) {
  const auto number = [&](const char* name, double fallback, double min, double max) {
    return argument_number(argc, argv, name, fallback, min, max);
  };
  modbus::Settings settings;
  settings.host = argument_text(argc, argv, "host", "127.0.0.1");
  if (settings.host.empty()) {
    std::fprintf(stderr, "property 'host' is empty; name the device, as in 10.0.0.7 or press.plant\n");
    std::exit(1);
  }
  settings.port = argument_whole(argc, argv, "port", 502, 1, 65535);
  settings.unit = argument_whole(argc, argv, "unit", 255, 0, 255);
  settings.cycle = modbus::Seconds{number("cycle", 0.02, 0.001, 60)};
  settings.timeout = modbus::Seconds{number("timeout", 0.3, 0.01, 5)};
  settings.backoff = modbus::Seconds{number("backoff", 2, 0.1, 60)};
  settings.watchdog = modbus::Seconds{number("watchdog", 1, 0.05, 60)};
  return settings;
}

}  // namespace

int main(int argc, char* argv[]) {
  modbus::Settings settings = settings_from(argc, argv);
  const std::vector<modbus::Point> points = modbus::points_or_end(argument_text(argc, argv, "map", nullptr));
  // By the place of their point; the ones of the other direction are empty.
  std::vector<std::unique_ptr<modbus::PointInput>> to_device(points.size());
  std::vector<std::unique_ptr<modbus::PointOutput>> from_device(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].out)
      to_device[i] = std::make_unique<modbus::PointInput>(points[i]);
    else
      from_device[i] = std::make_unique<modbus::PointOutput>(points[i]);
  }
  initPeriodExe();
  // A body that is released seldom is not one that stands still.
  settings.watchdog =
      std::max(settings.watchdog, modbus::Seconds{3e-9 * static_cast<double>(takt_period_ns())});

  const std::string who = settings.host + ":" + std::to_string(settings.port);
  exchange = new modbus::Exchange{points, settings, [who](const std::string& what) {
                                    std::fprintf(stderr, "%s: %s\n", who.c_str(), what.c_str());
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
      // What was not read again is not said again: a deadline at the connection then makes it stale.
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
