// The flight record of a device as its node keeps it: the memory that executors write, what happened beside
// it, and who makes traces of it.
//
// A trace of some seconds takes a tenth of a second to write, and the node's thread never waits. So it only
// gathers what it knows, and a thread of its own does the rest.
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
    std::string files;  ///< traces of faults are files whose names begin like this; empty: none is written
  };

  static Result<std::unique_ptr<FlightRecorder>> create(Options options, const schedule::DevicePlan& plan,
                                                        const channel::Channel& channel);
  /// A fault that was not written yet is.
  ~FlightRecorder();
  FlightRecorder(const FlightRecorder&) = delete;
  FlightRecorder& operator=(const FlightRecorder&) = delete;

  /// For the host.
  [[nodiscard]] const os::Fd& fd() const noexcept { return record_.fd(); }

  void changed(flight::Change change);
  /// The host that ran this executor has died: what its threads were at is in the channel for the last time.
  void host_died(std::size_t executor);
  /// Something went wrong: soon there is a file, one every kTraceEvery at most.
  void fault(const std::string& why);
  /// What was done in the last so many nanoseconds, as trace JSON of at most `most` bytes. `done` is called
  /// from step().
  void trace(Nanoseconds last, std::size_t most, std::function<void(const Result<std::string>&)> done);

  /// Looks at the executors' threads now and then, and hands out what is done.
  void step(Instant now);
  /// Nothing more is recorded. Does not wait: true once the last file is written, which may take a second;
  /// then the end takes no time.
  [[nodiscard]] bool finish();
  /// What is to be said: files that were written, or why not. Taken away.
  std::vector<std::string> news();

 private:
  struct Job {
    flight::Recording recording;
    std::size_t most = 0;
    std::function<void(const Result<std::string>&)> done{};  ///< none: it goes into a file
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
  std::vector<std::vector<flight::Open>> died_;  // of each ring
  Instant sampled_at_{};
  std::string fault_;  // not written yet; empty: none
  std::uint32_t faults_ = 0;
  Instant fault_at_{};
  std::optional<Instant> written_at_;
  std::uint64_t missed_ = 0;  // rows, as seen last
  std::optional<Instant> missed_at_;

  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<Job> jobs_;
  std::vector<Done> done_;
  std::vector<std::string> said_;
  bool end_ = false;
  std::atomic<bool> finished_{false};
  bool refused_ = false;  // the worker's: a file could not be written, and that was said
  std::thread worker_;
};

}  // namespace takt::node
