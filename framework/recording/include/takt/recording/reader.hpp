// Reads a recording, even if its recorder was killed or is still writing the recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

#include <takt/recording/database.hpp>
#include <takt/recording/schema.hpp>

namespace takt::recording {

struct PortOfRecording : RecordedPort {
  std::int64_t id = 0;
  std::uint64_t samples = 0;
  std::uint64_t missing = 0;  ///< number of samples that were lost between the recorded ones
  std::int64_t first_ns = 0;  ///< time of the port's first sample, in ns since 1970; 0 if there is none
  std::int64_t last_ns = 0;
};

struct RecordedSample {
  const PortOfRecording* port = nullptr;
  std::int64_t time_ns = 0;   ///< time of the sample, in ns since 1970
  std::uint64_t missing = 0;  ///< number of samples of this port that were lost before this sample
  const std::byte* bytes = nullptr;
  std::size_t size = 0;
};

/// Selects samples by port and time. Times are in ns since 1970.
struct Selection {
  std::set<std::int64_t> ports{};  ///< ids of ports; empty for all ports
  std::int64_t from_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t to_ns = std::numeric_limits<std::int64_t>::max();
};

/// An open recording. Only one thread at a time may use this object.
class Recording {
 public:
  /// Opens a recording. Fails if the file is not a recording, or if its ports cannot be read.
  static Result<Recording> open(const std::string& file);

  [[nodiscard]] const std::vector<PortOfRecording>& ports() const { return ports_; }
  /// The name of the recorded cell; empty if the recording has no sample yet.
  [[nodiscard]] const std::string& cell() const { return cell_; }
  /// The times of the first and the last sample; both are 0 if there is no sample.
  [[nodiscard]] std::int64_t first_ns() const { return first_ns_; }
  [[nodiscard]] std::int64_t last_ns() const { return last_ns_; }
  [[nodiscard]] std::uint64_t samples() const;

  /// Reads samples in the order in which they arrived, until `each` returns false. Samples that do not fit
  /// the type of their port are skipped and counted in `wrong`. If the file is damaged, fails after the
  /// readable part.
  Result<void> read(const Selection& selection, const std::function<bool(const RecordedSample&)>& each,
                    std::uint64_t& wrong);
  /// Reads the times of one port's samples.
  Result<std::vector<std::int64_t>> times(std::int64_t port, const Selection& selection);

 private:
  explicit Recording(Database database) : database_(std::move(database)) {}
  Result<void> load();

  Database database_;
  std::vector<PortOfRecording> ports_;
  std::string cell_;
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace takt::recording
