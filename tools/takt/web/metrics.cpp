#include "web/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <takt/wire/words.hpp>

#include "web/samples_json.hpp"

namespace takt::tool::web {

namespace {

using Labels = std::vector<std::pair<std::string_view, std::string>>;

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\' || c == '"') result += '\\';
    result += c == '\n' ? std::string{"\\n"} : std::string(1, c);
  }
  return result;
}

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return fmt::format("{}", value);
}

/// One metric with all of its samples, because the format requires the samples of a metric to be consecutive.
class Metric {
 public:
  Metric(std::string_view name, std::string_view type, std::string_view help)
      : name_(name), head_(fmt::format("# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help)) {}

  void add(const Labels& labels, double value) { add(labels, number(value)); }
  void add(const Labels& labels, std::uint64_t value) { add(labels, std::to_string(value)); }
  void add(const Labels& labels, bool value) { add(labels, value ? std::string{"1"} : std::string{"0"}); }

  [[nodiscard]] std::string text() const { return samples_.empty() ? "" : head_ + samples_; }

 private:
  void add(const Labels& labels, const std::string& value) {
    samples_ += name_;
    std::string_view before = "{";
    for (const auto& [label, text] : labels) {
      fmt::format_to(std::back_inserter(samples_), "{}{}=\"{}\"", before, label, escaped(text));
      before = ",";
    }
    samples_ += (labels.empty() ? " " : "} ") + value + "\n";
  }

  std::string name_;
  std::string head_;
  std::string samples_;
};

/// Adds the quantiles and the maximum of a distribution, converted from microseconds to seconds.
void add_quantiles(Metric& quantiles, Metric& largest, const Labels& labels, const Distribution& us) {
  const std::pair<const char*, double> all[] = {{"0.5", us.p50()}, {"0.99", us.p99()}, {"0.999", us.p999()}};
  for (const auto& [quantile, value] : all) {
    Labels one = labels;
    one.emplace_back("quantile", quantile);
    quantiles.add(one, value / 1e6);
  }
  largest.add(labels, us.max() / 1e6);
}

constexpr const char* kGauge = "gauge";
constexpr const char* kCounter = "counter";

std::string of_devices(const std::vector<wire::ObservedDevice>& devices, const model::Cell* cell) {
  Metric up{"takt_device_up", kGauge, "1 if the node of the device is alive, 0 if it is lost."};
  Metric state{"takt_device_state", kGauge,
               "1 for the current state of the device, 0 for every other state."};
  Metric health{"takt_device_health", kGauge,
                "1 for the current health of the device, 0 for every other health."};
  Metric real_time{"takt_device_real_time", kGauge,
                   "1 if the system allows real-time scheduling on the device, else 0."};
  Metric restarts{"takt_device_host_restarts_total", kCounter,
                  "Restarts of the device's host, which is its real-time process."};
  Metric forced{"takt_device_forced_inputs", kGauge, "Inputs of the device that an operator forces."};
  Metric alarms{"takt_device_unacknowledged_alarms", kGauge,
                "Alarms of the device and its modules that nobody has acknowledged."};
  Metric clock{"takt_device_clock_offset_seconds", kGauge,
               "How far the wall clock of the device is ahead of that of the cell's first device."};
  Metric clock_error{"takt_device_clock_offset_error_seconds", kGauge,
                     "The largest possible error of takt_device_clock_offset_seconds."};
  for (const wire::ObservedDevice& device : devices) {
    const DeviceStatus& s = device.status;
    const Labels labels{{"cell", s.cell().to_string()}, {"device", device.name()}};
    const auto with = [&labels](std::string_view name, const char* value) {
      Labels more = labels;
      more.emplace_back(name, value);
      return more;
    };
    up.add(labels, device.alive);
    if (!device.alive) continue;
    alarms.add(labels, std::uint64_t{s.unacknowledged_alarms()});
    for (auto i = static_cast<int>(DEVICE_WAITING); i <= static_cast<int>(DEVICE_ENDED); ++i)
      state.add(with("state", to_text(static_cast<DeviceState>(i))),
                s.state() == static_cast<DeviceState>(i));
    for (auto i = static_cast<int>(HEALTH_OK); i <= static_cast<int>(HEALTH_FAILED); ++i)
      health.add(with("health", to_text(static_cast<DeviceHealth>(i))),
                 s.health() == static_cast<DeviceHealth>(i));
    real_time.add(labels, s.real_time());
    restarts.add(labels, std::uint64_t{s.host_restarts()});
    const auto& ports = device.deployment.ports;
    forced.add(labels,
               static_cast<std::uint64_t>(std::count_if(ports.begin(), ports.end(), [](const auto& p) {
                 return p.second.status.forced().size() != 0;
               })));
    if (s.clock_error_ns() > 0) {
      clock.add(labels, static_cast<double>(s.clock_offset_ns()) / 1e9);
      clock_error.add(labels, static_cast<double>(s.clock_error_ns()) / 1e9);
    }
  }
  // Report a device of the cell as down if `devices` does not contain it: it was lost before this program
  // started.
  for (const model::Device& device : cell == nullptr ? std::vector<model::Device>{} : cell->devices) {
    const bool found = std::any_of(devices.begin(), devices.end(), [&](const wire::ObservedDevice& one) {
      return one.name() == device.name;
    });
    if (!found) up.add({{"cell", cell->name}, {"device", device.name}}, false);
  }
  return up.text() + state.text() + health.text() + real_time.text() + restarts.text() + forced.text() +
         alarms.text() + clock.text() + clock_error.text();
}

std::string of_modules(const std::vector<wire::ObservedDevice>& devices) {
  Metric state{"takt_module_state", kGauge,
               "1 for the current state of the module, 0 for every other state."};
  Metric cycles{"takt_module_cycles_total", kCounter, "Releases of the module."};
  Metric missed{"takt_module_missed_total", kCounter, "Releases of the module that were skipped."};
  Metric overruns{"takt_module_overruns_total", kCounter, "Releases at which the module was still running."};
  Metric over_budget{"takt_module_over_budget_total", kCounter,
                     "Runs of the module that took longer than its budget."};
  Metric errors{"takt_module_errors_total", kCounter, "Errors of the module."};
  Metric recoveries{"takt_module_recoveries_total", kCounter, "Recoveries of the module."};
  Metric jitter{"takt_module_jitter_seconds", kGauge,
                "Time between the release of the module and its start, by quantile."};
  Metric jitter_max{"takt_module_jitter_max_seconds", kGauge,
                    "Maximum time between a release and the start that follows."};
  Metric run{"takt_module_run_seconds", kGauge, "Run time of the module, by quantile."};
  Metric run_max{"takt_module_run_max_seconds", kGauge, "Maximum run time of the module."};
  for (const wire::ObservedDevice& device : devices) {
    if (!device.alive) continue;
    const auto labels_of = [&](const std::string& module) {
      return Labels{
          {"cell", device.status.cell().to_string()}, {"device", device.name()}, {"module", module}};
    };
    for (const auto& [name, s] : device.deployment.modules) {
      for (auto i = static_cast<int>(STATE_IDLE); i <= static_cast<int>(STATE_DESTRUCT); ++i) {
        Labels labels = labels_of(name);
        labels.emplace_back("state", to_text(static_cast<LifecycleState>(i)));
        state.add(labels, s.state() == static_cast<LifecycleState>(i));
      }
    }
    for (const auto& [name, m] : device.deployment.statistics) {
      const Labels labels = labels_of(name);
      cycles.add(labels, m.cycles());
      missed.add(labels, m.missed());
      overruns.add(labels, m.overruns());
      over_budget.add(labels, m.over_budget());
      errors.add(labels, m.errors());
      recoveries.add(labels, m.recoveries());
      add_quantiles(jitter, jitter_max, labels, m.jitter_us());
      add_quantiles(run, run_max, labels, m.run_us());
    }
  }
  return state.text() + cycles.text() + missed.text() + overruns.text() + over_budget.text() + errors.text() +
         recoveries.text() + jitter.text() + jitter_max.text() + run.text() + run_max.text();
}

std::string of_executors(const std::vector<wire::ObservedDevice>& devices) {
  Metric cycles{"takt_executor_cycles_total", kCounter, "Rows that the executor ran."};
  Metric missed{"takt_executor_missed_total", kCounter, "Rows of the executor that were skipped."};
  Metric late{"takt_executor_late_total", kCounter, "Rows of the executor that began late."};
  Metric margin{"takt_executor_margin_seconds", kGauge, "How long before a release the executor wakes up."};
  Metric jitter{"takt_executor_jitter_seconds", kGauge,
                "Time between the release of a row and its start, by quantile."};
  Metric jitter_max{"takt_executor_jitter_max_seconds", kGauge,
                    "Maximum time between a release and the start that follows."};
  for (const wire::ObservedDevice& device : devices) {
    if (!device.alive) continue;
    for (const auto& [name, e] : device.deployment.executors) {
      const Labels labels{
          {"cell", device.status.cell().to_string()}, {"device", device.name()}, {"executor", name}};
      cycles.add(labels, e.cycles());
      missed.add(labels, e.missed());
      late.add(labels, e.late());
      margin.add(labels, e.margin_us() / 1e6);
      add_quantiles(jitter, jitter_max, labels, e.jitter_us());
    }
  }
  return cycles.text() + missed.text() + late.text() + margin.text() + jitter.text() + jitter_max.text();
}

std::string of_connections(const std::vector<wire::ObservedDevice>& devices, const model::Cell& cell) {
  Metric matched{"takt_connection_matched", kGauge,
                 "1 if the writer and the reader of the connection have found each other."};
  Metric stale{"takt_connection_stale", kGauge,
               "1 if the newest value is older than the deadline of the connection."};
  Metric safe{"takt_connection_safe", kGauge, "1 if the reader gets the safe value of the connection."};
  Metric age{"takt_connection_age_seconds", kGauge, "Age of the newest value on the connection."};
  Metric lost{"takt_connection_lost_total", kCounter,
              "Samples that were lost between the writer and the reader."};
  Metric dropped{"takt_connection_dropped_total", kCounter,
                 "Samples that were dropped because the queue was full."};
  Metric late{"takt_connection_late_total", kCounter,
              "How often the newest value became older than the deadline."};
  for (const auto& [index, health] : health_of(cell, devices).connections) {
    const model::Connection& connection = cell.connections[index];
    const auto end = [](const model::Endpoint& e) { return e.given() ? to_text(e) : std::string{}; };
    const Labels labels{{"cell", cell.name},
                        {"from", end(connection.from)},
                        {"to", end(connection.to)},
                        {"topic", topic_of(cell, connection)}};
    matched.add(labels, health.matched);
    stale.add(labels, health.stale());
    safe.add(labels, health.safe);
    if (health.age) age.add(labels, std::chrono::duration<double>(*health.age).count());
    lost.add(labels, health.lost);
    dropped.add(labels, health.dropped);
    late.add(labels, health.late);
  }
  return matched.text() + stale.text() + safe.text() + age.text() + lost.text() + dropped.text() +
         late.text();
}

/// Keeps only one node of each name, because two nodes of the same name would write the same Prometheus
/// series. Prefers a node that is alive.
std::vector<wire::ObservedDevice> one_of_each(std::vector<wire::ObservedDevice> devices) {
  std::stable_partition(devices.begin(), devices.end(),
                        [](const wire::ObservedDevice& one) { return one.alive; });
  std::set<std::string> known;
  std::erase_if(devices, [&known](const wire::ObservedDevice& one) {
    return !known.insert(one.status.cell().to_string() + '/' + one.name()).second;
  });
  return devices;
}

}  // namespace

std::string metrics_text(const std::vector<wire::ObservedDevice>& seen, const model::Cell* cell,
                         const Counted& counted) {
  const std::vector<wire::ObservedDevice> devices = one_of_each(seen);
  std::string text = of_devices(devices, cell) + of_modules(devices) + of_executors(devices);
  if (cell != nullptr) text += of_connections(devices, *cell);
  Metric faults{"takt_faults_total", kCounter, "Events of the fault records since the gateway started."};
  for (const auto& [device, numbers] : counted.faults) {
    for (std::size_t severity = 0; severity < numbers.size(); ++severity)
      faults.add({{"device", device}, {"severity", model::to_text(static_cast<model::Severity>(severity))}},
                 numbers[severity]);
  }
  Metric viewers{"takt_web_viewers", kGauge, "Open event streams."};
  viewers.add({}, std::uint64_t{counted.viewers});
  return text + faults.text() + viewers.text();
}

}  // namespace takt::tool::web
