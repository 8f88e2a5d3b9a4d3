// Writes samples to a recording. Threads that receive samples must not wait for the disk, so the samples go
// through a bounded queue to the writer's own thread. RecordingOptions limit the size of the file.
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
  bool append = false;  ///< true: add the samples to the recording if the file exists
  /// Limit of the disk space, including that of SQLite's auxiliary files; 0 for no limit.
  std::uint64_t max_bytes = 1'000'000'000;
  Full full = Full::stop;
  Nanoseconds flush = std::chrono::milliseconds{500};       ///< the longest time that a sample waits in the
                                                            ///< queue
  std::size_t queue_bytes = std::size_t{64} * 1024 * 1024;  ///< limit of the memory for samples in the queue
};

struct RecordingHealth {
  std::uint64_t samples = 0;         ///< number of written samples
  std::uint64_t lost = 0;            ///< number of samples lost before add(), because the queue was full, or
                                     ///< because the disk failed
  std::uint64_t dropped = 0;         ///< number of old samples deleted so that new ones fit below the limit
  std::uint64_t bytes = 0;           ///< space used on the disk
  bool full = false;                 ///< true if the file has reached its limit; then the writer writes no
                                     ///< more samples
  std::optional<Problem> trouble{};  ///< the reason why the writer cannot write at present; empty if it can
                                     ///< write
};

class RecordingWriter {
 public:
  /// Creates the file, or opens it to append. Fails if the file cannot be written, if it exists although
  /// `append` is false, or if it is not a recording.
  static Result<std::unique_ptr<RecordingWriter>> create(const RecordingOptions& options);
  /// Calls finish().
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Adds a port and returns its number for add(). If the same port is added again, returns the same number.
  /// `cell` becomes the recording's cell if the recording has none yet. Any thread may call add_port().
  std::int64_t add_port(const RecordedPort& port, const std::string& cell = {});
  /// Adds a copy of the sample to the queue; never waits for the disk. Any thread may call add(), including
  /// threads of Fast DDS.
  void add(std::int64_t port, std::int64_t time_ns, const std::byte* bytes, std::size_t size);
  /// Records that `count` samples of the port were lost before the next one. Any thread may call miss().
  void miss(std::int64_t port, std::uint64_t count);

  [[nodiscard]] RecordingHealth health() const;
  /// The number of written samples of each port.
  [[nodiscard]] std::map<std::int64_t, std::uint64_t> counts() const;

  /// Writes the waiting samples, and removes SQLite's auxiliary files. After this call, the writer accepts no
  /// samples. Fails if not all samples could be written.
  Result<void> finish();

 private:
  struct Waiting {
    std::int64_t port;
    std::int64_t time_ns;
    std::uint64_t missing;
    std::size_t size;  ///< number of bytes; Batch::bytes contains the bytes of all samples
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
  /// Writes the batch, in transactions that fit into SQLite's log. Removes the written samples from the
  /// batch.
  Result<void> write(Batch& batch);
  Result<void> write_ports(const Batch& batch);
  Result<std::size_t> write_samples(const Batch& batch, std::size_t first, std::size_t offset);
  /// Makes sure that `bytes` more bytes fit below the size limit. If necessary and allowed, deletes the
  /// oldest samples for this. Returns false if the file is full.
  Result<bool> make_room(std::uint64_t bytes);
  Result<std::uint64_t> used();
  Result<void> checkpoint();
  void measure();

  const RecordingOptions options_;
  // Only the writer's thread uses these members.
  Database database_;
  std::optional<Statement> insert_;
  std::uint64_t page_ = 4096;
  std::uint64_t log_room_ = 0;  ///< limit of the size of SQLite's log file

  mutable std::mutex mutex_;
  std::condition_variable news_;
  Batch waiting_;
  std::map<std::tuple<std::string, std::string, bool, std::string>, std::int64_t> known_;
  std::int64_t last_port_ = 0;
  std::map<std::int64_t, std::uint64_t> missing_;  ///< by port: samples lost since the last one in the queue
  std::size_t taken_bytes_ = 0;                    ///< size of the batch that is being written
  std::map<std::int64_t, std::uint64_t> counts_;
  RecordingHealth health_;
  bool ending_ = false;
  bool finished_ = false;
  os::Thread thread_;
};

}  // namespace takt::recording
