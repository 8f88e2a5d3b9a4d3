#include <takt/simulation/random_cell.hpp>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <takt/core/check.hpp>
#include <takt/model/validate.hpp>

namespace takt::simulation {

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr std::array<Nanoseconds, 6> kPeriods{microseconds{500}, milliseconds{1}, milliseconds{2},
                                              milliseconds{4},   milliseconds{5}, milliseconds{10}};

class Maker {
 public:
  explicit Maker(std::uint64_t seed) : draws_(seed, "random cell") {}

  model::Cell make() {
    model::Cell cell;
    cell.name = "random";
    const std::uint64_t devices = 1 + draws_.below(3);
    for (std::uint64_t d = 0; d < devices; ++d) cell.devices.push_back(device("d" + std::to_string(d)));
    connect(cell);
    return cell;
  }

 private:
  template <class T, std::size_t N>
  T one_of(const std::array<T, N>& choices) {
    return choices[draws_.below(N)];
  }

  model::Device device(const std::string& name) {
    model::Device device;
    device.name = name;
    const std::uint64_t executors = 1 + draws_.below(2);
    const bool share = draws_.chance(0.5);
    for (std::uint64_t e = 0; e < executors; ++e) {
      model::Executor executor;
      executor.name = "e" + std::to_string(e);
      executor.priority = 80 - static_cast<int>(10 * e);
      if (share) executor.cpu = 1;
      executor.rate_monotonic = draws_.chance(0.2);
      if (draws_.chance(0.3)) executor.offsets = model::Offsets::automatic;
      if (draws_.chance(0.2)) executor.timing = model::Timing::let;
      if (draws_.chance(0.3)) executor.own_host = true;
      device.executors.push_back(executor);
    }
    const std::uint64_t modules = 1 + draws_.below(5);
    for (std::uint64_t m = 0; m < modules; ++m)
      device.modules.push_back(module("m" + std::to_string(m), device));
    return device;
  }

  model::Module module(const std::string& name, const model::Device& device) {
    model::Module module;
    module.name = name;
    const bool is_process = draws_.chance(0.25);
    module.type = is_process ? model::ModuleType::process : model::ModuleType::thread;
    module.filename = name + (is_process ? ".exe" : ".so");
    module.priority = static_cast<int>(draws_.below(4));
    module.recovery = {.attempts = static_cast<int>(draws_.below(4)),
                       .backoff = draws_.between(Nanoseconds{0}, Nanoseconds{milliseconds{30}}),
                       .then = draws_.chance(0.1) ? model::GiveUp::stop_device : model::GiveUp::destruct};
    const double kind = draws_.share();
    if (kind < 0.05) {
      module.operation = model::Operation::non_real;
      if (!is_process && draws_.chance(0.5)) module.period = one_of(kPeriods);
      return module;
    }
    module.executor = device.executors[draws_.below(device.executors.size())].name;
    if (kind < 0.7) {
      module.operation = model::Operation::periodic;
      module.period = one_of(kPeriods);
      // The budget is so small that the budgets of all modules of a device together fit into any row.
      if (draws_.chance(0.3))
        module.budget = kPeriods.front() / draws_.between(std::int64_t{6}, std::int64_t{30});
      if (module.budget && draws_.chance(0.3))
        module.tolerance.in_a_row = static_cast<int>(1 + draws_.below(3));
      if (draws_.chance(0.2))
        module.offset = kPeriods.front() * static_cast<std::int64_t>(draws_.below(static_cast<std::uint64_t>(
                                               *module.period / kPeriods.front())));
      if (draws_.chance(0.4)) module.overrun = contract(is_process);
      return module;
    }
    module.operation = model::Operation::sporadic;
    module.deadline = draws_.between(Nanoseconds{milliseconds{1}}, Nanoseconds{milliseconds{10}});
    if (draws_.chance(0.3)) module.miss = model::Miss::error;
    if (draws_.chance(0.4))
      module.interarrival = draws_.between(Nanoseconds{microseconds{100}}, Nanoseconds{milliseconds{5}});
    if (draws_.chance(0.5)) module.dispatch = model::Dispatch::immediate;
    return module;
  }

  model::OverrunContract contract(bool is_process) {
    const double kind = draws_.share();
    if (kind < 0.1) return {.what = model::Overrun::stop_device};
    if (kind < 0.4 || is_process) return {.what = model::Overrun::error};
    return {.what = model::Overrun::catch_up, .limit = static_cast<int>(1 + draws_.below(5))};
  }

  // Adds random connections between the modules. Each connection has its own input port.
  void connect(model::Cell& cell) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> places;
    for (std::uint32_t d = 0; d < cell.devices.size(); ++d) {
      for (std::uint32_t m = 0; m < cell.devices[d].modules.size(); ++m) {
        const model::Module& module = cell.devices[d].modules[m];
        // Non-real-time process modules get no connections, because their samples are not simulated.
        if (module.type == model::ModuleType::thread || module.operation != model::Operation::non_real)
          places.emplace_back(d, m);
      }
    }
    if (places.empty()) return;
    const auto end = [&cell](const auto& at, const std::string& port) {
      const model::Device& device = cell.devices[at.first];
      return model::Endpoint{device.name, device.modules[at.second].name, port};
    };
    const std::uint64_t connections = draws_.below(2 * places.size() + 1);
    for (std::uint64_t c = 0; c < connections; ++c) {
      model::Connection connection;
      const std::uint64_t from = draws_.below(places.size());
      const std::uint64_t to = draws_.below(places.size());
      connection.from = end(places[from], "out");
      connection.to = end(places[to], "in" + std::to_string(c));
      if (draws_.chance(0.5)) {
        connection.kind = model::ConnectionKind::queue;
        connection.depth = static_cast<int>(1 + draws_.below(6));
        connection.reliability = model::Reliability::reliable;
      }
      if (draws_.chance(0.3)) {
        connection.deadline = draws_.between(Nanoseconds{milliseconds{2}}, Nanoseconds{milliseconds{40}});
        // Only connections in one direction may have stale="error", because modules that wait for each other
        // would never recover.
        if (from < to && draws_.chance(0.5)) connection.stale = model::Stale::error;
      }
      if (draws_.chance(0.1))
        connection.lifespan = draws_.between(Nanoseconds{microseconds{200}}, Nanoseconds{milliseconds{5}});
      cell.connections.push_back(connection);
    }
  }

  Draws draws_;
};

}  // namespace

RandomCell random_cell(std::uint64_t seed) {
  RandomCell random{.cell = Maker{seed}.make(), .plans = {}, .options = {}};
  auto plans = schedule::plan(random.cell);
  TAKT_CHECK(plans && model::validate(random.cell).empty());
  random.plans = std::move(*plans);
  Draws draws{seed, "random options"};
  random.options.seed = seed;
  random.options.length = draws.between(Nanoseconds{milliseconds{20}}, Nanoseconds{milliseconds{300}});
  random.options.faults_per_second = draws.chance(0.2) ? 0 : static_cast<double>(draws.between(5, 100));
  random.options.cpus = static_cast<int>(draws.below(3));
  for (std::uint64_t commands = draws.chance(0.5) ? draws.below(10) : 0; commands != 0; --commands) {
    constexpr auto kFirst = static_cast<std::int64_t>(Injection::Kind::initialize);
    constexpr auto kLast = static_cast<std::int64_t>(Injection::Kind::swap);
    Injection command;
    command.kind = static_cast<Injection::Kind>(draws.between(kFirst, kLast));
    command.at = draws.between(Nanoseconds{0}, random.options.length);
    command.device = static_cast<std::uint32_t>(draws.below(random.cell.devices.size()));
    command.target =
        static_cast<std::uint32_t>(draws.below(random.cell.devices[command.device].modules.size()));
    random.options.injections.push_back(command);
  }
  return random;
}

}  // namespace takt::simulation
