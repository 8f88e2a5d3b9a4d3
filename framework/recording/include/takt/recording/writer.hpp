// Writes samples to a recording. Whoever receives them must not wait for the disk, and the disk must not run
// full: samples go through a bounded queue to a thread of the writer's own, and the file has a bound too.
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

/// What happens when a file has reached its bound.
enum class Full { stop, oldest };

inline constexpr std::uint64_t kLeastRecording = 1'000'000;  ///< bytes that a bound is at least

struct RecordingOptions {
  std::string file;
  bool append = false;                      ///< to a recording that is there
  std::uint64_t max_bytes = 1'000'000'000;  ///< on the disk, SQLite's own files included; 0: no bound
  Full full = Full::stop;
  Nanoseconds flush = std::chrono::milliseconds{500};       ///< how long a sample waits at most
  std::size_t queue_bytes = std::size_t{64} * 1024 * 1024;  ///< of samples that wait
};

struct RecordingHealth {
  std::uint64_t samples = 0;         ///< written
  std::uint64_t lost = 0;            ///< no room in the queue, or the disk did not take them
  std::uint64_t dropped = 0;         ///< the oldest, which made room for new ones
  std::uint64_t bytes = 0;           ///< on the disk
  bool full = false;                 ///< Full::stop: the bound is reached, and nothing more is written
  std::optional<Problem> trouble{};  ///< why the disk takes nothing at present
};

class RecordingWriter {
 public:
  /// Makes the file, or opens it to append. Fails where it is there already, cannot be written, or is no
  /// recording.
  static Result<std::unique_ptr<RecordingWriter>> create(const RecordingOptions& options);
  /// As finish().
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// The number by which its samples are added; the same for the same port again. `cell`: named as the
  /// recording's if it has none yet. Any thread.
  std::int64_t add_port(const RecordedPort& port, const std::string& cell = {});
  /// Any thread, also one of Fast DDS: copies, and never waits for the disk.
  void add(std::int64_t port, std::int64_t time_ns, const std::byte* bytes, std::size_t size);

  [[nodiscard]] RecordingHealth health() const;
  /// How many samples of each port were written.
  [[nodiscard]] std::map<std::int64_t, std::uint64_t> counts() const;

  /// Writes what still waits and leaves one file without others beside it. Nothing is taken afterwards. Fails
  /// where the disk did not take everything.
  Result<void> finish();

 private:
  struct Waiting {
    std::int64_t port;
    std::int64_t time_ns;
    std::size_t size;  ///< bytes of it, one sample's after the other's
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
  /// All of it, in transactions that the log has room for; what was written is taken from it.
  Result<void> write(Batch& batch);
  Result<void> write_ports(const Batch& batch);
  Result<std::size_t> write_samples(const Batch& batch, std::size_t first, std::size_t offset);
  /// Room for so many bytes below the bound; false when it is full.
  Result<bool> make_room(std::uint64_t bytes);
  Result<std::uint64_t> used();
  Result<void> checkpoint();
  void measure();

  const RecordingOptions options_;
  // Of the writer's thread.
  Database database_;
  std::optional<Statement> insert_;
  std::uint64_t page_ = 4096;
  std::uint64_t log_room_ = 0;  ///< what the log beside the file may take at most

  mutable std::mutex mutex_;
  std::condition_variable news_;
  Batch waiting_;
  std::map<std::tuple<std::string, std::string, bool, std::string>, std::int64_t> known_;
  std::int64_t last_port_ = 0;
  std::size_t taken_bytes_ = 0;  ///< of the batch that is being written
  std::map<std::int64_t, std::uint64_t> counts_;
  RecordingHealth health_;
  bool ending_ = false;
  bool finished_ = false;
  os::Thread thread_;
};

}  // namespace takt::recording
