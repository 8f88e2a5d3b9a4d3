// takt echo: prints the samples of a port, field by field.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/client/port_names.hpp>
#include <takt/client/tap.hpp>
#include <takt/core/words.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/type.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/signals.hpp>
#include <takt/wire/words.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/target.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

/// After this time without a sample, takt echo prints the cause, if the states of module and device show it.
constexpr auto kPause = std::chrono::milliseconds{200};
/// After this time without a sample, takt echo reports the silence even if the cause is not known.
constexpr auto kQuiet = std::chrono::seconds{2};

struct EchoOptions {
  std::string port;
  bool rate = false;
  std::uint64_t count = 0;  ///< the number of samples to print; 0 means until Ctrl-C
  client::Network network;
};

/// The samples that have arrived but have not been printed yet. Their number is limited, because a terminal
/// may be slower than a port.
class Samples {
 public:
  void add(const std::byte* bytes, std::size_t size) {
    ++seen_;
    const std::lock_guard lock{mutex_};
    if (waiting_.size() < kMost) waiting_.emplace_back(bytes, bytes + size);
  }
  std::deque<std::vector<std::byte>> take() {
    const std::lock_guard lock{mutex_};
    return std::exchange(waiting_, {});
  }
  [[nodiscard]] std::uint64_t seen() const noexcept { return seen_; }

 private:
  static constexpr std::size_t kMost = 10000;
  std::mutex mutex_;
  std::deque<std::vector<std::byte>> waiting_;
  std::atomic<std::uint64_t> seen_{0};
};

/// Returns why no samples arrive, as far as the states of the port's module and device explain it; empty if
/// the module is EXECUTING or its state is not known.
std::string cause_of_quiet(const client::Connection& client, const client::PortName& name) {
  const std::string path = name.device + "." + name.module;
  for (const wire::ObservedDevice& seen : client.observer->devices(name.device)) {
    if (!seen.alive) return "device " + name.device + " is lost";
    const auto found = seen.deployment.modules.find(name.module);
    if (found == seen.deployment.modules.end()) continue;
    const LifecycleState state = found->second.state();
    if (wire::is_stopped(found->second) && seen.status.state() == DEVICE_RUNNING)
      return path + " is stopped, in START; takt start " + path + " starts it";
    if (state != STATE_EXECUTING) return path + " does not run; it is in " + to_text(state);
  }
  return {};
}

/// Returns the problem that a name is not that of a port. If it is the name of a module, the problem lists
/// the outputs of this module.
Problem no_port(const EchoOptions& options) {
  const Problem problem = fail(in_quotes(options.port) + " is not a port name", "write DEVICE.MODULE.PORT");
  const auto module = module_of(options.port);
  if (!module) return problem;
  const auto client = connect_to_device(options.network, module->device, module->module);
  if (!client) return problem;
  const auto answer = client::accepted(client->sender->send(
      {.kind = COMMAND_DESCRIBE, .device = module->device, .limit = std::chrono::seconds{10}}));
  const auto described = answer ? client::described_modules(module->device, answer->data) : answer.problems();
  if (!described) return problem;
  for (const auto& one : *described) {
    if (one.at("name") != module->module) continue;
    const auto ports = model::parse_ports(model::json_text({{"ports", one.at("ports")}}));
    std::vector<std::string> outputs;
    for (const model::Port& port : ports ? *ports : std::vector<model::Port>{}) {
      if (port.direction == model::Direction::out) outputs.push_back(options.port + "." + port.name);
    }
    return fail(options.port + " is a module, not a port",
                outputs.empty() ? "it has no outputs"
                                : "its outputs are " + one_of({outputs.begin(), outputs.end()}));
  }
  return problem;
}

int echo(const EchoOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  const auto name = client::parse_port(options.port);
  if (!name) return refuse({no_port(options)});
  const auto client = connect_to_device(options.network, name->device, name->module + "." + name->port);
  if (!client) return refuse(client.problems());

  const auto flow = client::tapped(*client->sender, options.port);
  if (!flow) return refuse(flow.problems());

  Samples samples;
  const auto tap = dds::Tap::create(
      client->participant, *flow,
      [&](const std::byte* bytes, std::size_t size, std::int64_t) { samples.add(bytes, size); });
  if (!tap) return refuse(tap.problems());

  Instant again = os::now() + client::kAskAgain;
  Instant rate_since = os::now();
  std::uint64_t samples_before = 0;
  std::uint64_t printed = 0;
  Instant last_sample = os::now();  // or the start, before the first sample
  bool quiet_printed = false;
  std::uint64_t received = 0;
  while (options.count == 0 || printed < options.count) {
    os::wait_readable({&signals->fd()}, 20);
    if (signals->next()) break;
    if (os::output_has_no_reader()) return kNoReader;
    const Instant now = os::now();
    if (now >= again) {
      again = now + client::kAskAgain;
      if (const auto longer = client::tapped(*client->sender, options.port); !longer)
        return refuse(longer.problems());
    }
    if (const std::uint64_t seen = samples.seen(); seen != received) {
      received = seen;
      last_sample = now;
      quiet_printed = false;
    }
    if (!quiet_printed && now - last_sample >= kPause) {
      const std::string cause = cause_of_quiet(*client, *name);
      quiet_printed = !cause.empty() || now - last_sample >= kQuiet;
      if (!cause.empty()) {
        tell("no samples from " + options.port + ": " + cause);
      } else if (quiet_printed) {
        std::fprintf(stderr, "no sample from %s in the last %lld s\n", options.port.c_str(),
                     static_cast<long long>(kQuiet.count()));
      }
    }
    const auto arrived = samples.take();
    if (options.rate) {
      const double seconds = std::chrono::duration<double>(now - rate_since).count();
      if (seconds < 1) continue;
      const std::uint64_t seen = samples.seen();
      if (!print(fmt::format("{:.1f} Hz, {} samples, {} lost\n",
                             static_cast<double>(seen - samples_before) / seconds, seen,
                             (*tap)->health().lost))) {
        return 1;
      }
      ++printed;
      rate_since = now;
      samples_before = seen;
      continue;
    }
    for (const auto& sample : arrived) {
      if (options.count != 0 && printed == options.count) break;
      if (!print(model::sample_json(flow->type, sample.data(), sample.size()) + "\n")) return 1;
      ++printed;
    }
  }
  return 0;
}

}  // namespace

void add_echo(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<EchoOptions>();
  auto* command = app.add_subcommand("echo", "Print the samples of a port, one per line, until Ctrl-C");
  command->add_option("PORT", options->port, "DEVICE.MODULE.PORT")->required();
  command->add_flag("--hz", options->rate, "print the number of samples per second instead of the samples");
  command->add_option("-n,--count", options->count, "end after this many lines")
      ->type_name("N")
      ->check([](const std::string& text) {
        return text == "0" ? std::string{"it must be at least 1; leave it out to print until Ctrl-C"}
                           : std::string{};
      });
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return echo(*options); }; });
}

}  // namespace takt::tool
