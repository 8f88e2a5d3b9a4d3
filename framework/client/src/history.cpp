#include <takt/client/history.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace takt::client {

namespace {

/// A device publishes statistics about once a second. History skips statistics that a device publishes less
/// than this time after the last entry.
constexpr std::int64_t kApart_ms = 900;

std::int64_t milliseconds_of(std::int64_t ns) { return ns / 1'000'000; }

/// Computes the mean of only the measurements that were made since the previous statistics. `mean` and
/// `count` are from the present statistics, `mean_before` and `count_before` from the previous statistics.
double between(double mean, double count, double mean_before, double count_before) {
  return (mean * count - mean_before * count_before) / (count - count_before);
}

double mean_square(const Distribution& d) { return d.variance() + d.mean() * d.mean(); }

}  // namespace

void History::add(Module& module, const ModuleStatistics& now) {
  const ModuleStatistics& before = module.last;
  const auto value = [](double of) { return static_cast<float>(of); };
  const bool loaded_afresh = now.cycles() < before.cycles();
  Entry entry{.time_ms = milliseconds_of(now.time_ns()),
              .jitter_p50 = value(now.jitter_us().p50()),
              .jitter_p99 = value(now.jitter_us().p99()),
              .run_p50 = value(now.run_us().p50()),
              .run_p99 = value(now.run_us().p99()),
              .jitter = std::numeric_limits<float>::quiet_NaN(),
              .run = std::numeric_limits<float>::quiet_NaN()};
  if (!module.entries.empty() && now.cycles() != before.cycles()) {
    const auto count = static_cast<double>(now.cycles());
    const double count_before = loaded_afresh ? 0 : static_cast<double>(before.cycles());
    const double square = between(mean_square(now.jitter_us()), count,
                                  loaded_afresh ? 0 : mean_square(before.jitter_us()), count_before);
    const double run =
        between(now.run_us().mean(), count, loaded_afresh ? 0 : before.run_us().mean(), count_before);
    // Rounding may make `square` or `run` slightly negative.
    entry.jitter = value(std::sqrt(std::max(square, 0.0)));
    entry.run = value(std::max(run, 0.0));
  }
  module.last = now;
  if (module.entries.size() < kSeconds) {
    module.entries.push_back(entry);
    return;
  }
  module.entries[module.next] = entry;
  module.next = (module.next + 1) % kSeconds;
}

void History::add(const std::vector<wire::ObservedDevice>& devices) {
  for (auto& [name, module] : modules_) module.seen = false;
  for (const wire::ObservedDevice& device : devices) {
    for (const auto& [name, statistics] : device.deployment.statistics) {
      const std::string path = device.name() + "." + name;
      auto found = modules_.find(path);
      if (found == modules_.end()) {
        if (modules_.size() >= kModules) continue;
        found = modules_.emplace(path, Module{}).first;
      }
      Module& module = found->second;
      module.seen = true;
      const std::int64_t apart =
          milliseconds_of(statistics.time_ns()) - milliseconds_of(module.last.time_ns());
      if (!module.entries.empty() && apart < 0) {  // the device's clock was set back
        module.entries.clear();
        module.next = 0;
      }
      if (module.entries.empty() || apart >= kApart_ms) add(module, statistics);
    }
  }
  std::erase_if(modules_, [](const auto& entry) { return !entry.second.seen; });
}

Series History::of(const std::string& module, std::size_t seconds) const {
  Series series;
  const auto found = modules_.find(module);
  if (found == modules_.end()) return series;
  const std::vector<Entry>& entries = found->second.entries;
  const std::size_t newest = std::min(seconds, entries.size());
  for (std::size_t i = entries.size() - newest; i < entries.size(); ++i) {
    const Entry& entry = entries[(found->second.next + i) % entries.size()];
    series.times_ms.push_back(entry.time_ms);
    series.jitter_p50_us.push_back(entry.jitter_p50);
    series.jitter_p99_us.push_back(entry.jitter_p99);
    series.run_p50_us.push_back(entry.run_p50);
    series.run_p99_us.push_back(entry.run_p99);
    series.jitter_us.push_back(entry.jitter);
    series.run_us.push_back(entry.run);
  }
  return series;
}

}  // namespace takt::client
