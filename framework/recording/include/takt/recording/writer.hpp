// Writes samples to a recording. Threads that receive samples must not wait for the disk, so the samples go
// through a bounded queue to the writer's own thread. The size of the file is limited too.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/real_time.hpp>

#include <takt/recording/database.hpp>
#include <takt/recording/schema.hpp>

namespace takt::recording {

/// What to do when the file reaches its size limit: stop, or drop the oldest samples.
enum class Full { stop, oldest };

inline constexpr std::uint64_t kLeastRecording = 1'000'000;  ///< the smallest size limit, in bytes

struct RecordingOptions {
  std::string file;
  bool append = false;                      ///< append to an existing recording
  std::uint64_t max_bytes = 1'000'000'000;  ///< on the disk, including SQLite's own files; 0: no limit
  Full full = Full::stop;
  Nanoseconds flush = std::chrono::milliseconds{500};       ///< the longest time that a sample waits
  std::size_t queue_bytes = std::size_t{64} * 1024 * 1024;  ///< the most bytes of waiting samples
};

struct RecordingHealth {
  std::uint64_t samples = 0;         ///< written
  std::uint64_t lost = 0;            ///< the queue was full, or the disk did not take them
  std::uint64_t dropped = 0;         ///< oldest samples that made room for new ones
  std::uint64_t bytes = 0;           ///< on the disk
  bool full = false;                 ///< with Full::stop: the limit is reached, and nothing more is written
  std::optional<Problem> trouble{};  ///< the reason if the disk takes nothing at present
};

class RecordingWriter {
 public:
  /// Creates the file, or opens it to append. Fails if it exists without `append`, cannot be written, or is
  /// not a recording.
  static Result<std::unique_ptr<RecordingWriter>> create(const RecordingOptions& options);
  /// Calls finish().
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Returns the port's number for add(); the same port gets the same number. `cell` becomes the recording's
  /// cell if it has none yet. Any thread.
  std::int64_t add_port(const RecordedPort& port, const std::string& cell = {});
  /// Copies the sample, and never waits for the disk. Any thread, including those of Fast DDS.
  void add(std::int64_t port, std::int64_t time_ns, const std::byte* bytes, std::size_t size);

  [[nodiscard]] RecordingHealth health() const;
  /// The number of written samples of each port.
  [[nodiscard]] std::map<std::int64_t, std::uint64_t> counts() const;

  /// Writes the waiting samples, and leaves one file without auxiliary files. Nothing is accepted afterwards.
  /// Fails if the disk did not take everything.
  Result<void> finish();

 private:
  struct Waiting {
    std::int64_t port;
    std::int64_t time_ns;
    std::size_t size;  ///< bytes of the sample; all samples' bytes are concatenated
  };
  struct NewPort {
    std::int64_t id;
    RecordedPort port;
  };
  struct Batch {
    std::vector<NewPort> ports;
    std::string cell;
    std::vector<Waiting> samples;
    std::vector<std::byte> bytes;
    [[nodiscard]] bool empty() const { return ports.empty() && cell.empty() && samples.empty(); }
  };

  RecordingWriter(RecordingOptions options, Database database);
  Result<void> prepare();
  void work();
  /// Writes the batch in transactions for which the log has room; removes from the batch what was written.
  Result<void> write(Batch& batch);
  Result<void> write_ports(const Batch& batch);
  Result<std::size_t> write_samples(const Batch& batch, std::size_t first, std::size_t offset);
  /// Makes room for this many bytes below the limit; returns false if the file is full.
  Result<bool> make_room(std::uint64_t bytes);
  Result<std::uint64_t> used();
  Result<void> checkpoint();
  void measure();

  const RecordingOptions options_;
  // Only for the writer's thread.
  Database database_;
  std::optional<Statement> insert_;
  std::uint64_t page_ = 4096;
  std::uint64_t log_room_ = 0;  ///< the most bytes of the log beside the file

  mutable std::mutex mutex_;
  std::condition_variable news_;
  Batch waiting_;
  std::map<std::tuple<std::string, std::string, bool, std::string>, std::int64_t> known_;
  std::int64_t last_port_ = 0;
  std::size_t taken_bytes_ = 0;  ///< size of the batch that is being written
  std::map<std::int64_t, std::uint64_t> counts_;
  RecordingHealth health_;
  bool ending_ = false;
  bool finished_ = false;
  os::Thread thread_;
};

}  // namespace takt::recording
