#include <takt/node/control.hpp>

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include <takt/descriptor/descriptor.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/validate.hpp>
#include <takt/node/log.hpp>
#include <takt/node/supervisor.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/signals.hpp>

namespace takt::node {

namespace {

using json = nlohmann::ordered_json;
using Phase = Supervisor::Phase;

/// How often a node looks at what its executors published.
constexpr int kLookEveryMs = 5;

std::string dump(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

Result<Supervisor::Options> find_device(const NodeOptions& options) {
  auto cell = descriptor::load(options.file);
  if (!cell) return cell.problems();
  const auto device = std::find_if(cell->devices.begin(), cell->devices.end(),
                                   [&](const model::Device& d) { return d.name == options.device; });
  if (device == cell->devices.end()) {
    std::string names;
    for (const auto& d : cell->devices) names += (names.empty() ? "" : ", ") + d.name;
    return Problem{options.file, "there is no device " + options.device, "it has " + names};
  }
  const auto index = static_cast<std::size_t>(device - cell->devices.begin());
  auto paths = host::check_components(*cell);
  if (!paths) return paths.problems();
  return Supervisor::Options{.cell = std::move(*cell),
                             .device = index,
                             .paths = paths->at(index),
                             .require_real_time = options.require_real_time};
}

// Serves the device until it has ended.
void serve(Supervisor& device, os::MessageSocket& control, const os::SignalQueue& signals) {
  const bool alone = !control.fd();
  bool ready_said = false;
  while (device.phase() != Phase::ended) {
    std::vector<const os::Fd*> fds = device.wait_on();
    fds.push_back(&signals.fd());
    if (!control.closed()) fds.push_back(&control.fd());
    os::wait_readable(fds, kLookEveryMs);

    while (signals.next()) device.stop();
    device.step();
    if (device.phase() == Phase::ready && !ready_said) {
      ready_said = true;
      if (alone)
        device.go(os::now() + std::chrono::milliseconds{100});
      else
        control.send(dump({{"event", "ready"}}));
    }
    while (!alone && !control.closed()) {
      const auto text = control.receive();
      if (!text) break;
      const json message = json::parse(*text, nullptr, false);
      if (message.value("do", "") == "go") device.go(from_ns(message.at("t0")));
      if (message.value("do", "") == "stop") device.stop();
    }
    if (control.closed()) device.stop();
  }
}

}  // namespace

int run_node(const NodeOptions& options) {
  if (options.quiet) log_nothing();
  os::survive_broken_pipes();  // whoever reads our log may go; the device stays
  os::MessageSocket control{os::take_fd_from_environment(kControlFd)};
  auto signals = os::SignalQueue::of_requests_to_end();
  const auto refuse = [&](const Problems& problems) {
    std::fprintf(stderr, "%s\n", to_text(problems).c_str());
    return 1;
  };
  if (!signals) return refuse(signals.problems());
  auto found = find_device(options);
  if (!found) return refuse(found.problems());
  Supervisor device{std::move(*found)};
  if (const auto prepared = device.prepare(); !prepared) return refuse(prepared.problems());
  serve(device, control, *signals);

  json failures = json::array();
  for (const Problem& problem : device.failures()) failures.push_back(to_text(problem));
  if (control.fd()) {
    control.send_wait(dump({{"event", "ended"}, {"report", device.report()}, {"failures", failures}}));
  } else {
    for (const Problem& problem : device.failures()) std::fprintf(stderr, "%s\n", to_text(problem).c_str());
  }
  return device.failures().empty() ? 0 : 1;
}

}  // namespace takt::node
