// Reads the fault records of all nodes as one log, and follows it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/fault.hpp>

namespace takt::client {

/// What a node reports about its fault record.
struct DeviceLog {
  std::string device;
  std::string file;                 ///< on its machine; empty: the record is only in memory
  std::uint64_t newest = 0;         ///< number of the newest event; 0: there is none
  std::int64_t newest_time_ns = 0;  ///< the latest time of all events
  std::uint64_t overwritten = 0;    ///< number of older events that newer ones have replaced
  std::uint64_t damaged = 0;        ///< number of slots in the file that do not hold a valid event
};

struct Log {
  std::vector<model::Fault> events;  ///< of all devices, by time
  std::vector<DeviceLog> devices;    ///< devices that answered
  Problems problems;                 ///< why other devices did not answer
};

/// Asks the filter's device, or all devices. A device that the others have lost, or that they name but that
/// is not found from here, is reported in `problems`. The search is that of all_reports().
Log read_log(Operator& asker, const model::FaultFilter& filter, Nanoseconds limit = std::chrono::seconds{3});

/// Sorts by time. The events of one device stay in the order of their numbers.
void sort_by_time(std::vector<model::Fault>& events);

/// Receives every event from now on.
class LogFollower {
 public:
  /// Create it before reading the log that it continues, so that no event falls between the two.
  static Result<std::unique_ptr<LogFollower>> create(std::shared_ptr<dds::Participant> participant);
  ~LogFollower();

  /// Continues after the last events of this log.
  void go_on_after(const Log& log);
  /// The events since the last call; waits at most `limit` for one. Requests events that were lost on the
  /// way again, and reports those that it cannot get in `problems`.
  std::vector<model::Fault> next(Operator& asker, Nanoseconds limit, Problems& problems);

 private:
  struct Inside;
  explicit LogFollower(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::client
