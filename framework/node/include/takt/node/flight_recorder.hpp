// Keeps a device's flight record, which is the memory where executors record their runs, and collects what
// else happened at the same time. Writes traces of both.
//
// A trace that covers several seconds takes a tenth of a second to write, and the node's thread must never
// wait. So the node's thread only gathers the data, and a worker thread does the rest.
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
    std::string files;  ///< beginning of the paths of fault traces; empty to write no traces
  };

  static Result<std::unique_ptr<FlightRecorder>> create(Options options, const schedule::DevicePlan& plan,
                                                        const channel::Channel& channel);
  /// Writes the trace of a fault if it is still pending.
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// The descriptor of the record's memory, for the host.
  [[nodiscard]] const os::Fd& fd() const noexcept { return record_.fd(); }

  /// Records a module's lifecycle step.
  void changed(flight::Change change);
  /// Notes what the threads of this executor were doing when their host died. Call this before the channel is
  /// cleared, because the channel still shows it.
  void host_died(std::size_t executor);
  /// Requests a trace file of a fault. The file is written soon, but at most one file every kTraceEvery.
  void fault(const std::string& why);
  /// Makes a trace of the time from `last` ago until now, as JSON of at most `most` bytes. step() calls
  /// `done` with the result.
  void trace(Nanoseconds last, std::size_t most, std::function<void(const Result<std::string>&)> done);

  /// Samples the executors' threads from time to time, and calls `done` for finished traces.
  void step(Instant now);
  /// Stops recording, without waiting. Call this repeatedly until it returns true, which may take a second.
  /// Then the last file is written, and the destructor does not block.
  [[nodiscard]] bool finish();
  /// Returns the messages since the last call, which report each trace file that was written or could not be
  /// written.
  std::vector<std::string> messages();

 private:
  struct Job {
    flight::Recording recording;
    std::size_t most = 0;
    std::function<void(const Result<std::string>&)> done{};  ///< empty if the trace goes into a file
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
  std::vector<std::vector<flight::Open>> died_;  // for each ring, what was running when its host died
  Instant sampled_at_{};
  std::string fault_;  // the fault whose trace is pending; empty if there is none
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
  bool write_failed_ = false;  // whether the worker failed to write the last file and reported it
  std::thread worker_;
};

}  // namespace takt::node
