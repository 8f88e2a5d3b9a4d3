// The alarms of a device: the faults that need somebody. An alarm lasts from its fault until an operator has
// acknowledged it, even if its cause has gone. The states are those of ISA-18.2 and IEC 62682.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/core/result.hpp>
#include <takt/model/fault.hpp>

namespace takt::model {

struct Acknowledgement {
  std::string by;    ///< the operator
  std::string note;  ///< may be empty
  std::int64_t time_ns = 0;
  bool operator==(const Acknowledgement&) const = default;
};

struct Alarm {
  /// The sequence number of the event that must be acknowledged: the first one of this kind since the alarm
  /// was acknowledged last.
  std::uint64_t number = 0;
  std::int64_t since_ns = 0;
  std::int64_t last_ns = 0;  ///< time of the newest event
  std::string device{};
  std::string module{};  ///< empty if the alarm concerns the whole device
  FaultKind kind = FaultKind::error;
  std::string error{};
  std::string cause{};      ///< of the newest event
  std::uint64_t count = 1;  ///< number of occurrences since `since_ns`
  bool active = false;      ///< false: the cause has gone ("returned to normal"), or was a single event
  std::optional<Acknowledgement> acknowledged{};
  bool operator==(const Alarm&) const = default;
};

/// Returns the state of an alarm: "unacknowledged", "acknowledged" or "unacknowledged, returned to normal".
/// An alarm that was acknowledged and has returned to normal does not exist any more.
const char* state_of(const Alarm& alarm) noexcept;
/// Returns true if `a` comes before `b` in a list of alarms: first those that nobody has acknowledged, then
/// those that are active, then errors, then the newest.
bool is_worse(const Alarm& a, const Alarm& b) noexcept;

nlohmann::ordered_json to_json(const Alarm& alarm);
nlohmann::ordered_json to_json(const std::vector<Alarm>& alarms);
/// Converts JSON to alarms. Returns none if the value is not a list of alarms.
std::optional<std::vector<Alarm>> alarms_from(const nlohmann::ordered_json& value);

/// The alarms of one device, computed from its events. The same events lead to the same alarms, so a node
/// restores them from its fault record.
class Alarms {
 public:
  /// If there are more, the oldest acknowledged one is forgotten, or else the oldest one.
  static constexpr std::size_t kMost = 64;

  /// Takes the next event of the fault record: it may raise an alarm, end the cause of one, or acknowledge
  /// one.
  void take(const Fault& fault);
  /// Updates which alarms are active whose cause is a present state. `is_faulty` returns true if a module is
  /// in RECOVER or was given up, and, for an empty name, if the device has failed as a whole. `is_in_cell`
  /// returns true if another device belongs to the cell; a device that does not is not lost any more.
  void update(const std::function<bool(const std::string& module)>& is_faulty,
              const std::function<bool(const std::string& device)>& is_in_cell);

  [[nodiscard]] const std::vector<Alarm>& all() const noexcept { return alarms_; }
  /// Returns the alarms that an operator can acknowledge: those of a module, or of the device and all of its
  /// modules if `module` is empty; only the one with the number `number`, unless it is 0.
  [[nodiscard]] std::vector<Alarm> unacknowledged(const std::string& module = {},
                                                  std::uint64_t number = 0) const;
  /// Returns true if an active alarm says that this other device is lost.
  [[nodiscard]] bool is_lost(const std::string& device) const;
  /// Returns the numbers of the unacknowledged alarms: the record must keep these events, so that a restarted
  /// node finds them.
  [[nodiscard]] std::vector<std::uint64_t> needed() const;
  /// Counts the changes.
  [[nodiscard]] std::uint64_t changes() const noexcept { return changes_; }

 private:
  std::vector<Alarm> alarms_;  // in the order in which they were raised
  std::uint64_t changes_ = 0;
};

/// The data of COMMAND_ACKNOWLEDGE.
struct Acknowledge {
  static constexpr std::size_t kLongestNote = 255;  ///< in bytes

  std::string note{};
  std::uint64_t alarm = 0;  ///< the number of the only alarm that is meant; 0: all
};
nlohmann::ordered_json to_json(const Acknowledge& acknowledge);
/// Reads the data of COMMAND_ACKNOWLEDGE, which anybody may have sent. The problem says what is not valid.
Result<Acknowledge> acknowledge_from(std::string_view json);

/// Returns the cause of the event with which the fault record says that an alarm was acknowledged.
/// Alarms::take() reads it.
std::string acknowledgement_text(const Alarm& alarm, const std::string& by, const std::string& note);

}  // namespace takt::model
