#include <takt/os/trial.hpp>

#include <sys/timex.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iterator>
#include <string>
#include <utility>

#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/process.hpp>
#include <takt/os/real_time.hpp>

namespace takt::os {

namespace {

constexpr Nanoseconds kPause = std::chrono::milliseconds{1};
// The default priority of executors.
constexpr int kPriority = 80;

// The estimate of the kernel grows by 500 us each second, up to 16 s. Each service that synchronises the
// clock reduces the estimate, but not every one also clears STA_UNSYNC.
std::optional<Nanoseconds> wall_clock_error() noexcept {
  timex state{};
  if (::adjtimex(&state) < 0 || state.maxerror >= 16'000'000) return std::nullopt;
  return std::chrono::microseconds{state.maxerror};
}

// Tries to lock memory. Does this in a child process, because this process would keep its memory locked.
Result<void> try_locking() {
  if (auto allowed = may_lock_memory(); !allowed) return allowed;
  const auto tried = in_child(
      "locking memory", [] { return lock_memory() ? std::string{} : std::string{"refused"}; },
      std::chrono::seconds{5});
  if (!tried) return tried.problems();
  if (!tried->empty()) return fail("mlockall is denied", "free memory, or raise the memlock limit");
  return {};
}

}  // namespace

WakeUps wake_ups_of(std::vector<Nanoseconds> delays) {
  if (delays.empty()) return {};
  std::sort(delays.begin(), delays.end());
  const std::size_t last = delays.size() - 1;
  return {
      .count = delays.size(), .p50 = delays[last / 2], .p99 = delays[last * 99 / 100], .max = delays[last]};
}

std::vector<int> executor_cpus(const std::vector<int>& isolated, const model::Cpus& cpus) {
  std::vector<int> chosen;
  std::set_intersection(isolated.begin(), isolated.end(), cpus.permitted.begin(), cpus.permitted.end(),
                        std::back_inserter(chosen));
  if (chosen.empty() && !cpus.ordinary.empty()) chosen.push_back(cpus.ordinary.back());
  return chosen;
}

std::vector<int> executor_cpus() { return executor_cpus(read_isolated_cpus(), read_cpus()); }

WakeUps try_wake_ups(std::size_t count, Nanoseconds pause) {
  std::vector<Nanoseconds> delays(count);
  const NoDeepIdle no_deep_idle;
  Problems refused;  // ignored, because executors also run without a priority if the system denies it
  auto thread = Thread::start(
      {.name = "takt-probe", .priority = kPriority, .cpus = {executor_cpus().back()}},
      [&delays, pause] {
        Instant until = now();
        for (Nanoseconds& delay : delays) {
          until = std::max(until + pause, now());
          sleep_until(until);
          delay = now() - until;
        }
      },
      &refused);
  if (!thread) return {};
  thread->join();
  return wake_ups_of(std::move(delays));
}

Nanoseconds timer_resolution() noexcept {
  timespec resolution{};
  ::clock_getres(CLOCK_MONOTONIC, &resolution);
  return std::chrono::seconds{resolution.tv_sec} + Nanoseconds{resolution.tv_nsec};
}

Trial try_machine(Nanoseconds moment) {
  Trial trial;
  trial.cpus = read_cpus();
  trial.root = is_root();
  trial.priority = may_have_priority();
  trial.locking = try_locking();
  if (!NoDeepIdle{}.held())
    trial.idle_held = fail("/dev/cpu_dma_latency cannot be opened", "let this user write to it");
  trial.timer_resolution = timer_resolution();
  trial.wall_clock_error = wall_clock_error();
  const auto before = read_processor_time();
  trial.wake_ups = try_wake_ups(static_cast<std::size_t>(moment / kPause), kPause);
  const auto after = read_processor_time();
  if (before && after) trial.stolen_share = after->stolen_share(*before);
  return trial;
}

}  // namespace takt::os
