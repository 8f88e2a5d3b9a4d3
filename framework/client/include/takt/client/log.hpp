// Reads the fault records of all nodes as one log, and follows this log as new events arrive.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/fault.hpp>

namespace takt::client {

/// The data that a device's node reports about its fault record.
struct DeviceLog {
  std::string device;
  std::string file;                 ///< path on the node's machine; empty if the record is only in memory
  std::uint64_t newest = 0;         ///< sequence number of the newest event; 0 if there is none
  std::int64_t newest_time_ns = 0;  ///< the latest time of an event, in ns since 1970
  std::uint64_t overwritten = 0;    ///< number of old events that newer events have overwritten
  std::uint64_t damaged = 0;        ///< number of slots in the file that do not hold a valid event
};

struct Log {
  std::vector<model::Fault> events;  ///< events of all devices, sorted by time
  std::vector<DeviceLog> devices;    ///< one entry for each device that answered
  Problems problems;                 ///< the reasons why other devices are not in `devices`
};

/// Reads the fault record of the filter's device. If the filter names no device, reads the records of all
/// devices that all_reports() finds. Then `problems` lists each device that other devices have lost, and each
/// device that other devices name but that this program does not find. Waits no longer for answers when
/// `give_up` returns true.
Log read_log(Operator& sender, const model::FaultFilter& filter, const std::function<bool()>& give_up = {});

/// Sorts the events by time. The sequence numbers of a device may then not be in order, because a node's rate
/// limit merges events, and records a merged event up to a second after the event's time. If the clock of a
/// device was set back by more than two seconds, the device's later events still follow its earlier ones.
void sort_by_time(std::vector<model::Fault>& events);

/// Receives all events that nodes record after the creation of this object.
class LogFollower {
 public:
  /// Starts to receive events. Call create() before read_log(). Otherwise the program would miss events that
  /// a node records after read_log() and before create().
  static Result<std::unique_ptr<LogFollower>> create(std::shared_ptr<dds::Participant> participant);
  ~LogFollower();

  /// Makes next() return only events that are newer than those of this log.
  void go_on_after(const Log& log);
  /// Returns the events received since the last call. If there are none, waits for one, but at most for
  /// `limit`. If events were lost on the network, requests them from the nodes. Adds a problem to `problems`
  /// if a node does not send these events.
  std::vector<model::Fault> next(Operator& sender, Nanoseconds limit, Problems& problems);

 private:
  struct Inside;
  explicit LogFollower(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::client
