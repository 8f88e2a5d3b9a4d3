// Keeps a device's flight record (the memory in which executors record their runs), and collects the
// lifecycle transitions and the kernel's counters of the same period. Writes all of these data into traces.
//
// Writing a trace of several seconds takes a tenth of a second, and the node's main thread must never wait.
// So the main thread only gathers the data, and a worker thread writes the trace.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <takt/channel/channel.hpp>
#include <takt/channel/flight_record.hpp>
#include <takt/core/result.hpp>
#include <takt/flight/recording.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::node {

class FlightRecorder {
 public:
  struct Options {
    std::string cell;
    std::string device;
    std::vector<flight::Module> modules;
    std::vector<std::string> executors;
    std::string files;  ///< beginning of the paths of fault traces; if empty, no traces are written
  };

  static Result<std::unique_ptr<FlightRecorder>> create(Options options, const schedule::DevicePlan& plan,
                                                        const channel::Channel& channel);
  /// Writes the trace of the last fault, if it is not yet written, and waits for the worker thread.
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// Returns the file descriptor of the record's memory, for the host.
  [[nodiscard]] const os::Fd& fd() const noexcept { return record_.fd(); }

  /// Records a lifecycle transition of a module.
  void changed(flight::Change change);
  /// Notes what the threads of this executor were doing when their host died. This information comes from the
  /// channel, so call host_died() before the channel is cleared.
  void host_died(std::size_t executor);
  /// Requests a trace file of a fault. The recorder writes the file 200 ms later, but at most one file in
  /// each interval of kTraceEvery.
  void fault(const std::string& why);
  /// Makes a trace of the time from `last` before now until now, as JSON of at most `most` bytes. A later
  /// step() calls `done` with the trace.
  void trace(Nanoseconds last, std::size_t most, std::function<void(const Result<std::string>&)> done);

  /// Reads the kernel's counters of the executors' threads every 50 ms, and calls `done` for each finished
  /// trace. The node's main thread calls this in each iteration of its loop.
  void step(Instant now);
  /// Stops recording, without waiting. Call finish() repeatedly until it returns true; this may take a
  /// second. When it has returned true, the last file is written, and the destructor does not block.
  [[nodiscard]] bool finish();
  /// Returns the messages since the last call. Each message reports a trace file that was written or could
  /// not be written.
  std::vector<std::string> messages();

 private:
  struct Job {
    flight::Recording recording;
    std::size_t most = 0;
    /// Receives the trace; empty if the trace goes into a file.
    std::function<void(const Result<std::string>&)> done{};
  };
  struct Done {
    std::function<void(const Result<std::string>&)> done;
    std::string text;
  };

  FlightRecorder(Options options, const schedule::DevicePlan& plan, const channel::Channel& channel);
  void sample(Instant now);
  void check_missed();
  [[nodiscard]] flight::Recording gather(const std::string& why, Nanoseconds last) const;
  void enqueue(Job job);
  void write_fault();
  void work();
  void write_file(const std::string& text, std::int64_t wall_ns);

  Options options_;
  const channel::Channel& channel_;
  channel::FlightRecord record_;
  std::vector<Nanoseconds> basic_periods_;
  std::string machine_;
  std::string kernel_;
  Nanoseconds minor_fault_{};

  std::deque<flight::Sample> samples_;
  std::deque<flight::Change> changes_;
  // For each ring, the activities of its thread at the times when a host died.
  std::vector<std::vector<flight::Open>> died_;
  Instant sampled_at_{};
  std::string fault_;  // the reason for a fault whose trace is not yet written; empty if there is none
  bool only_missed_ = false;  // true: the only reason so far is that rows were missed
  std::uint32_t faults_ = 0;
  Instant fault_at_{};
  std::optional<Instant> written_at_;
  std::uint64_t missed_ = 0;  // number of missed rows at the last check
  std::optional<Instant> missed_at_;

  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<Job> jobs_;
  std::vector<Done> done_;
  std::vector<std::string> messages_;
  bool end_ = false;
  std::atomic<bool> finished_{false};
  bool write_failed_ = false;  // true if the worker could not write the last file and has reported this
  std::thread worker_;
};

}  // namespace takt::node
