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

/// A node's report about its fault record.
struct DeviceLog {
  std::string device;
  std::string file;                 ///< path on its machine; empty if the record is only in memory
  std::uint64_t newest = 0;         ///< number of the newest event; 0 if there is none
  std::int64_t newest_time_ns = 0;  ///< the latest time of all events
  std::uint64_t overwritten = 0;    ///< number of older events that newer ones have replaced
  std::uint64_t damaged = 0;        ///< number of slots in the file that do not hold a valid event
};

struct Log {
  std::vector<model::Fault> events;  ///< events of all devices, sorted by time
  std::vector<DeviceLog> devices;    ///< devices that answered
  Problems problems;                 ///< why the other devices did not answer
};

/// Reads the fault record of the filter's device, or of all devices, which all_reports() finds. `problems`
/// reports each device that other devices have lost, or that they name but that is not found from here.
Log read_log(Operator& asker, const model::FaultFilter& filter, Nanoseconds limit = std::chrono::seconds{3});

/// Sorts the events by time. Events of one device stay in the order of their numbers.
void sort_by_time(std::vector<model::Fault>& events);

/// Receives all events after its creation.
class LogFollower {
 public:
  /// Starts to receive events. Call this before read_log(), so that no event between the two is missed.
  static Result<std::unique_ptr<LogFollower>> create(std::shared_ptr<dds::Participant> participant);
  ~LogFollower();

  /// Makes next() continue after the last events of this log.
  void go_on_after(const Log& log);
  /// Returns the events since the last call; waits at most `limit` for an event. Asks the nodes for events
  /// that were lost on the network, and reports in `problems` the events that it cannot get.
  std::vector<model::Fault> next(Operator& asker, Nanoseconds limit, Problems& problems);

 private:
  struct Inside;
  explicit LogFollower(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::client
