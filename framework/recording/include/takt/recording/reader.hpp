// Reads a recording, also one whose recorder was killed, and one that is being written.
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
  std::int64_t first_ns = 0;  ///< of its samples, since 1970; 0 where it has none
  std::int64_t last_ns = 0;
};

struct RecordedSample {
  const PortOfRecording* port = nullptr;
  std::int64_t time_ns = 0;  ///< since 1970
  const std::byte* bytes = nullptr;
  std::size_t size = 0;
};

/// Which samples; times since 1970.
struct Selection {
  std::set<std::int64_t> ports{};  ///< ids; empty: all
  std::int64_t from_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t to_ns = std::numeric_limits<std::int64_t>::max();
};

/// One thread at a time.
class Recording {
 public:
  /// Fails on what is no recording, and where its ports cannot be read.
  static Result<Recording> open(const std::string& file);

  [[nodiscard]] const std::vector<PortOfRecording>& ports() const { return ports_; }
  /// Of its cell; empty where it has no sample yet.
  [[nodiscard]] const std::string& cell() const { return cell_; }
  /// The first and the last sample's time; both 0 where it has none.
  [[nodiscard]] std::int64_t first_ns() const { return first_ns_; }
  [[nodiscard]] std::int64_t last_ns() const { return last_ns_; }
  [[nodiscard]] std::uint64_t samples() const;

  /// In the order in which they came, until `each` returns false. Samples that are none of their port's type
  /// are left out and counted in `wrong`. Fails where the file is damaged, after what could be read.
  Result<void> read(const Selection& selection, const std::function<bool(const RecordedSample&)>& each,
                    std::uint64_t& wrong);
  /// The times of one port's samples.
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
