// Judges the health of connections, modules and devices. `takt status`, `takt watch`, `takt graph --live`,
// the page of `takt web` and the node all use this judgement, so that one connection never looks good in one
// place and bad in another.
//
// A judgement says what happens now. The counters of a report cover the whole time since the deployment, so
// they do not decide: a connection that lost samples yesterday is good today.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <takt/core/time.hpp>

namespace takt::wire {

enum class Rating {
  good,
  idle,   ///< grey: a module or device does not run, and this is no fault
  poor,   ///< amber: samples are being lost or dropped, an input is forced, a module is in a safe stop, or a
          ///< device is degraded
  bad,    ///< red: the value is stale, or the reader gets the safe value
  broken  ///< red: the writer and the reader have not found each other, although both belong to the cell
};
/// "good", "idle", "poor", "bad" or "broken".
const char* to_text(Rating rating) noexcept;

/// What is known of a connection now.
struct ConnectionReport {
  bool matched = true;                    ///< the writer and the reader have found each other
  bool outside = false;                   ///< one end is another program, which need not run
  bool output = false;                    ///< the report comes from the writer
  bool safe = false;                      ///< the reader gets the safe value
  std::optional<Nanoseconds> age{};       ///< the age of the newest value; none if there is no value yet
  std::optional<Nanoseconds> deadline{};  ///< the largest age that the reader accepts; none for a writer
  bool losing = false;                    ///< `lost` has risen within kRecently
  bool dropping = false;                  ///< `dropped` has risen within kRecently
  std::uint64_t lost = 0;                 ///< samples lost between devices
  std::uint64_t dropped = 0;              ///< samples dropped because the queue was full
  std::uint64_t late = 0;                 ///< how often the value became stale
  std::string incompatible{};             ///< the QoS policy that prevents matching, or empty
  std::string forced{};                   ///< who forces the reader's input, or empty

  [[nodiscard]] bool stale() const noexcept { return deadline && (!age || *age > *deadline); }
};

struct Judgement {
  Rating rating = Rating::good;
  std::string word{};    ///< "ok", "degraded", "stale", "not matched"
  std::string detail{};  ///< "drops samples", or empty

  /// "degraded: drops samples"
  [[nodiscard]] std::string reason() const { return word + (detail.empty() ? "" : ": " + detail); }
};

Judgement judge(const ConnectionReport& connection);

/// What is known of a module now. `state` is its state as text, for example "EXECUTING".
struct ModuleReport {
  std::string_view state;
  bool lost = false;       ///< its device is lost, so `state` is the last known one
  bool given_up = false;   ///< the node gave the module up after an error
  bool safe_stop = false;  ///< the module works as intended, and keeps its machine stopped for safety
  bool forced = false;     ///< an operator forces an input of the module
};
Rating judge(const ModuleReport& module) noexcept;

/// What is known of a device now. `state` and `health` are texts, for example "running" and "ok".
struct DeviceReport {
  std::string_view state;
  std::string_view health;
  bool alive = true;
};
Rating judge(const DeviceReport& device) noexcept;
/// What an operator can do about a lost device.
inline constexpr const char* kLostRemedy =
    "check the network and the machine; if the node has ended, start it again with --resume";

/// A queue that dropped a sample this recently is dropping samples.
inline constexpr Nanoseconds kRecently = std::chrono::seconds{5};

/// Detects whether a counter rises now.
class RisingCount {
 public:
  RisingCount() = default;
  /// Counts a first value above `count` as a rise. Without this, the first value is only the start.
  explicit RisingCount(std::uint64_t count) : count_(count) {}

  /// Takes the value of the counter at the time `now`, on any one clock. Returns true if the counter begins
  /// to rise: it is higher than before, and did not rise in the time kRecently before.
  bool update(std::uint64_t count, Nanoseconds now);
  /// True if the counter rose within kRecently before `now`.
  [[nodiscard]] bool rises(Nanoseconds now) const noexcept;

 private:
  std::optional<std::uint64_t> count_{};
  std::optional<Nanoseconds> rose_at_{};
};

}  // namespace takt::wire
