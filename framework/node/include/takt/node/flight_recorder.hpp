// Keeps a device's flight record: the memory that executors write, and what happened around it. Writes
// traces of both.
//
// A trace of some seconds takes a tenth of a second to write, and the node's thread must never wait. So the
// node's thread only gathers the data, and a worker thread does the rest.
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
    std::string files;  ///< how the names of the trace files of faults begin; empty: none is written
  };

  static Result<std::unique_ptr<FlightRecorder>> create(Options options, const schedule::DevicePlan& plan,
                                                        const channel::Channel& channel);
  /// Writes the trace of a fault that is still pending.
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// The record's memory, for the host.
  [[nodiscard]] const os::Fd& fd() const noexcept { return record_.fd(); }

  /// Records a module's lifecycle step.
  void changed(flight::Change change);
  /// The host that ran this executor has died. Call this before the channel is cleared, because the channel
  /// still shows what the host's threads were doing.
  void host_died(std::size_t executor);
  /// Requests a trace file of a fault. It is written soon, at most one file every kTraceEvery.
  void fault(const std::string& why);
  /// Makes a trace of the last so many nanoseconds, as JSON of at most `most` bytes. `done` is called from
  /// step().
  void trace(Nanoseconds last, std::size_t most, std::function<void(const Result<std::string>&)> done);

  /// Samples the executors' threads from time to time, and calls `done` for finished traces.
  void step(Instant now);
  /// Stops recording. Does not wait: true once the last file is written, which may take a second. After that
  /// the destructor does not block.
  [[nodiscard]] bool finish();
  /// The messages since the last call: which trace files were written, or why one was not.
  std::vector<std::string> messages();

 private:
  struct Job {
    flight::Recording recording;
    std::size_t most = 0;
    std::function<void(const Result<std::string>&)> done{};  ///< none: the trace goes into a file
  };
  struct Done {
    std::function<void(const Result<std::string>&)> done;
    std::string text;
  };

  FlightRecorder(Options options, const schedule::DevicePlan& plan, const channel::Channel& channel);
  void sample(Instant now);
  void watch_missed();
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

  std::deque<flight::Sample> samples_;
  std::deque<flight::Change> changes_;
  std::vector<std::vector<flight::Open>> died_;  // for each ring: what was running when its host died
  Instant sampled_at_{};
  std::string fault_;  // whose trace is pending; empty: none
  std::uint32_t faults_ = 0;
  Instant fault_at_{};
  std::optional<Instant> written_at_;
  std::uint64_t missed_ = 0;  // rows, at the last check
  std::optional<Instant> missed_at_;

  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<Job> jobs_;
  std::vector<Done> done_;
  std::vector<std::string> messages_;
  bool end_ = false;
  std::atomic<bool> finished_{false};
  bool write_failed_ = false;  // worker thread: the last file could not be written, which was reported
  std::thread worker_;
};

}  // namespace takt::node
