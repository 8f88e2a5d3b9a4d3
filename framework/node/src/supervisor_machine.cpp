// What of the machine spoils the run: said before it begins, and when it is seen.
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

// An executor that the kernel kept from its processor finds its next row late by as much. The kernel itself
// says so once, up to Linux 6.11, and names nobody.
void Supervisor::watch_gaps() {
  while (const auto text = kernel_news_.next()) {
    if (text->find("RT throttling activated") != std::string::npos) log("warning: the kernel says: " + *text);
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

void Supervisor::say_violations() {
  if (!violations_) return;
  for (const std::string& text : violations_->blind()) log("warning: " + text);
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

// Once, when nothing runs any more.
void Supervisor::fail_by_violations() {
  if (!violations_) return;
  for (const auto& [module, count] : violations_->counts()) {
    const bool of_executor = (module & channel::kOfExecutor) != 0;
    const std::string name = of_executor ? "executor " + device().name + "." +
                                               device().executors.at(module & ~channel::kOfExecutor).name
                                         : "module " + device().name + "." + members_.at(module)->model.name;
    failures_.push_back({name,
                         "is not real-time: it did " + std::to_string(count) +
                             (count == 1 ? " thing" : " things") + " that no real-time code may",
                         "see each of them with the calls that led there in the report"});
  }
}

}  // namespace takt::node
