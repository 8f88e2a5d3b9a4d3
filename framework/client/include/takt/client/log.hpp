// The fault records of all nodes as one: read, and followed.
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

/// What a node says of its record.
struct DeviceLog {
  std::string device;
  std::string file;                 ///< on its machine; empty: in its memory alone
  std::uint64_t newest = 0;         ///< number of the newest event; 0: there is none
  std::int64_t newest_time_ns = 0;  ///< the latest time of all
  std::uint64_t overwritten = 0;    ///< older events, which newer ones took the place of
  std::uint64_t damaged = 0;        ///< slots of the file whose content is no event
};

struct Log {
  std::vector<model::Fault> events;  ///< of all devices, by time
  std::vector<DeviceLog> devices;    ///< that answered
  Problems problems;                 ///< those that did not, and why
};

/// Asks the filter's device, or all that are there: those that the others miss, or name and that are not
/// found from here, are among the problems. They are looked for as all_reports() does.
Log read_log(Operator& asker, const model::FaultFilter& filter, Nanoseconds limit = std::chrono::seconds{3});

/// Events by their time; of one device in the order of their numbers.
void sort_by_time(std::vector<model::Fault>& events);

/// Every event from now on.
class LogFollower {
 public:
  /// To be made before the log is read that it goes on from, so that nothing is between the two.
  static Result<std::unique_ptr<LogFollower>> create(std::shared_ptr<dds::Participant> participant);
  ~LogFollower();

  /// Goes on after what this log had.
  void go_on_after(const Log& log);
  /// What has come since; waits at most `limit` for something. Events that were lost on the way are asked
  /// for; what cannot be had is said in `problems`.
  std::vector<model::Fault> next(Operator& asker, Nanoseconds limit, Problems& problems);

 private:
  struct Inside;
  explicit LogFollower(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::client
