// Reports what on the machine spoils the run: before it begins, and when it is detected.
#include <takt/channel/violations.hpp>
#include <takt/node/supervisor.hpp>
#include <takt/os/real_time.hpp>
#include "conditions.hpp"
#include "limits.hpp"

namespace takt::node {

void Supervisor::watch_conditions() {
  throttling_ = os::read_throttling();
  seen_latest_ns_.assign(device().executors.size(), 0);
  throttled_.assign(device().executors.size(), false);
  const Conditions conditions{.throttling = throttling_,
                              .prioritised = os::may_have_priority().ok(),
                              .memory_locked = os::may_lock_memory().ok(),
                              .swap_bytes = os::read_swap_bytes().value_or(0),
                              .timer_resolution = os::timer_resolution(),
                              .wake_ups = options_.wake_ups};
  for (const std::string& warning : warnings_for(device(), plan_, conditions)) log("warning: " + warning);
}

// Detects that the kernel kept an executor from its CPU: its next row is late by that time. The kernel
// itself reports throttling only once, up to Linux 6.11, and without a name.
void Supervisor::watch_gaps() {
  while (const auto text = kernel_news_.next()) {
    if (text->find("RT throttling activated") != std::string::npos)
      log("warning: the kernel reports: " + *text);
  }
  if (!rows_begun_ || !throttling_ || !real_time_) return;
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    const std::int64_t latest = channel_.executor(e).latest_ns.load(std::memory_order_relaxed);
    if (latest == seen_latest_ns_[e] || throttled_[e]) continue;
    seen_latest_ns_[e] = latest;
    if (const auto text = throttled(device().executors[e], Nanoseconds{latest}, *throttling_)) {
      throttled_[e] = true;
      log("warning: " + *text);
    }
  }
}

void Supervisor::report_violations() {
  if (!violations_) return;
  for (const std::string& text : violations_->limitations()) log("warning: " + text);
  for (const SeenViolation& violation : violations_->news(options_.paths)) {
    if ((violation.module & channel::kOfExecutor) != 0) {
      log("WARNING: executor " + device().executors.at(violation.module & ~channel::kOfExecutor).name +
          " is not real-time: " + sentence_of(violation));
    } else {
      log(*members_.at(violation.module),
          "WARNING: " + violation.hook + " is not real-time: " + sentence_of(violation));
      note(*members_.at(violation.module), model::FaultKind::not_real_time,
           violation.hook + ": " + sentence_of(violation));
    }
  }
}

// Makes the violations failures of the device. Called once, when nothing runs any more.
void Supervisor::fail_by_violations() {
  if (!violations_) return;
  for (const auto& [module, count] : violations_->counts()) {
    const bool of_executor = (module & channel::kOfExecutor) != 0;
    const std::string name = of_executor ? "executor " + device().name + "." +
                                               device().executors.at(module & ~channel::kOfExecutor).name
                                         : "module " + device().name + "." + members_.at(module)->model.name;
    failures_.push_back({name,
                         "is not real-time: " + std::to_string(count) +
                             (count == 1 ? " violation" : " violations") + " of the rules of real-time code",
                         "the report lists each violation with the calls that led to it"});
  }
}

}  // namespace takt::node
