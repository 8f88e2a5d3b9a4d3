#include "conditions.hpp"

#include <algorithm>

#include <takt/model/validate.hpp>
#include <takt/os/waker.hpp>

namespace takt::node {

namespace {

// Returns the longest delay of a wake-up that does no harm to this executor. A hybrid executor wakes up early
// by its margin, so a row is late only if the delay is longer than the margin. A row that is late by a tenth
// of the period does no harm. A row of an executor that sleeps may be late by half of the period, and an
// executor that spins needs no wake-up.
Nanoseconds allowed_delay(const model::Executor& executor, Nanoseconds basic_period) {
  switch (executor.wakeup) {
    case model::Wakeup::hybrid:
      return os::margin_cap(basic_period, executor.spin_share) + basic_period / 10;
    case model::Wakeup::sleep:
      return basic_period / 2;
    case model::Wakeup::spin:
      break;
  }
  return Nanoseconds::max();
}

std::string kept_of(const os::Throttling& throttling) {
  const std::string of =
      throttling.period == std::chrono::seconds{1} ? "each second" : "each " + to_text(throttling.period);
  return to_text(throttling.kept) + " of " + of;
}

// Formats a measured time, cut off to three significant digits.
std::string about(Nanoseconds time) {
  Nanoseconds unit{1};
  while (time / unit >= 1000) unit *= 10;
  return to_text(time / unit * unit);
}

}  // namespace

std::string throttling_cure(const os::Throttling& throttling) {
  const char* const mount = throttling.seen ? "" : "mount -t debugfs none /sys/kernel/debug; ";
  return throttling.fair_server
             ? std::string{mount} +
                   "for cpu in /sys/kernel/debug/sched/fair_server/cpu*; do echo 0 > $cpu/runtime; done"
             : "sysctl -w kernel.sched_rt_runtime_us=-1";
}

std::vector<std::string> warnings_for(const model::Device& device, const schedule::DevicePlan& plan,
                                      const Conditions& conditions) {
  std::vector<std::string> warnings;
  for (const schedule::ExecutorPlan& mine : plan.executors) {
    const model::Executor& executor = device.executors.at(mine.executor);
    const Nanoseconds basic = mine.basic_period;
    if (basic == Nanoseconds{0}) continue;
    const auto& throttling = conditions.throttling;
    if (executor.wakeup == model::Wakeup::spin && conditions.prioritised && throttling && throttling->on()) {
      warnings.push_back("executor " + executor.name + " never sleeps, so the kernel interrupts it for " +
                         kept_of(*throttling) +
                         (throttling->fair_server ? " when an ordinary thread waits for its CPU"
                                                  : " (real-time throttling)") +
                         "; use wakeup=\"hybrid\", or run " + throttling_cure(*throttling));
    }
    if (executor.wakeup == model::Wakeup::spin) continue;
    if (basic < model::kMinPeriod) {
      warnings.push_back(
          "executor " + executor.name + " has a basic period of " + to_text(basic) +
          ", the greatest common divisor of its periods and offsets: no machine is that fast, and most "
          "rows will be missed; choose periods and offsets with a larger divisor in common");
    } else if (conditions.timer_resolution >= basic) {
      warnings.push_back("the kernel's timers have no high resolution: executor " + executor.name +
                         " has a period of " + to_text(basic) + ", but is woken at most once each " +
                         to_text(conditions.timer_resolution) +
                         "; boot a kernel with CONFIG_HIGH_RES_TIMERS and without highres=off");
    } else if (conditions.wake_ups.p50 > allowed_delay(executor, basic)) {
      warnings.push_back("this machine woke threads about " + about(conditions.wake_ups.p50) +
                         " late when the node started (median of " +
                         std::to_string(conditions.wake_ups.count) + " tries), too late for executor " +
                         executor.name + " with its period of " + to_text(basic) +
                         "; run takt doctor to find the cause, or use wakeup=\"spin\" or a longer period");
    }
  }
  if (!conditions.memory_locked && conditions.swap_bytes > 0)
    warnings.emplace_back(
        "memory is not locked and this machine swaps: a module may wait for the disk; allow Takt to lock "
        "memory, or run swapoff -a");
  return warnings;
}

std::optional<std::string> throttled(const model::Executor& executor, Nanoseconds gap,
                                     const os::Throttling& throttling) {
  // The measured gap may be a little shorter than the time for which the kernel throttles. It may also be
  // longer, because other threads may run before the executor.
  const bool about_as_long = gap >= throttling.kept * 9 / 10 && gap <= throttling.kept * 3 / 2;
  if (!throttling.on() || !about_as_long) return std::nullopt;
  const bool spins = executor.wakeup == model::Wakeup::spin;
  // For an executor that sleeps, the text says "possibly", because something else may have taken the CPU,
  // such as firmware or the host of this virtual machine.
  return "executor " + executor.name + " lost its CPU for " + about(gap) + ": " +
         (spins ? "the kernel" : "possibly because the kernel") + " reserves " + kept_of(throttling) +
         " for ordinary threads" + (throttling.fair_server ? " (fair server)" : " (real-time throttling)") +
         "; " +
         (spins ? "use wakeup=\"hybrid\", or run " : "give its modules less work, run takt doctor, or run ") +
         throttling_cure(throttling);
}

}  // namespace takt::node
