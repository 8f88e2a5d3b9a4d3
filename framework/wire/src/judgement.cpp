#include <takt/wire/judgement.hpp>

namespace takt::wire {

const char* to_text(Rating rating) noexcept {
  switch (rating) {
    case Rating::good:
      return "good";
    case Rating::idle:
      return "idle";
    case Rating::poor:
      return "poor";
    case Rating::bad:
      return "bad";
    case Rating::broken:
      return "broken";
  }
  return "?";
}

Judgement judge(const ConnectionReport& connection) {
  // The reader does not use the connection now, so a force hides the state of the connection.
  if (!connection.forced.empty()) return {Rating::poor, "forced", "by " + connection.forced};
  if (!connection.incompatible.empty()) return {Rating::broken, "not matched", connection.incompatible};
  if (!connection.matched && !connection.outside) return {Rating::broken, "not matched"};
  // Before the first value, the reader gets the safe value without any fault.
  if (connection.safe && connection.age) return {Rating::bad, "safe value"};
  if (connection.stale()) return {Rating::bad, "stale"};
  if (connection.losing || connection.dropping) {
    std::string what = connection.losing ? "loses" : "drops";
    if (connection.losing && connection.dropping) what = "loses and drops";
    return {Rating::poor, "degraded", what + " samples"};
  }
  if (!connection.matched)
    return {Rating::good, connection.output ? "no other program reads it" : "no other program writes it"};
  // An event that has not happened yet sends no value, so a missing value alone is no fault.
  if (!connection.age && !connection.output) return {Rating::good, "ok", "no value yet"};
  return {Rating::good, "ok"};
}

Rating judge(const ModuleReport& module) noexcept {
  if (module.lost || module.state == "RECOVER" || (module.state == "DESTRUCT" && module.given_up))
    return Rating::bad;
  if (module.state != "EXECUTING") return Rating::idle;
  return module.safe_stop || module.forced ? Rating::poor : Rating::good;
}

Rating judge(const DeviceReport& device) noexcept {
  if (!device.alive || device.health == "failed") return Rating::bad;
  if (device.health != "ok") return Rating::poor;
  return device.state == "running" ? Rating::good : Rating::idle;
}

bool RisingCount::update(std::uint64_t count, Nanoseconds now) {
  const bool rose = count_ && count > *count_;
  const bool begins = rose && !rises(now);
  count_ = count;  // the counter of a new deployment begins again at 0
  if (rose) rose_at_ = now;
  return begins;
}

bool RisingCount::rises(Nanoseconds now) const noexcept {
  // If someone has set the clock back, `now` may be before rose_at_.
  return rose_at_ && now < *rose_at_ + kRecently && now > *rose_at_ - kRecently;
}

}  // namespace takt::wire
