// Sends lifecycle transitions so that no transition overwrites the previous one.
//
// The topic keeps only the last sample of each module, so that late readers get only the present state. But
// if a module makes two transitions in quick succession, the second sample could overwrite the first before a
// reader on a busy machine has received the first. So the second sample of a module waits until the first is
// acknowledged. Samples of other modules do not wait. A dead reader acknowledges nothing until its lease
// expires. So the wait has a limit, and the limit is short after a wait that failed.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <set>
#include <string>

#include <takt/wire/takt.h>
#include <takt/core/time.hpp>

namespace takt::node {

/// The destination of transitions: a dds::Writer, or a fake in tests. Only one thread uses the sink.
class LifecycleSink {
 public:
  virtual ~LifecycleSink() = default;
  virtual bool write(const LifecycleStatus& status) = 0;
  virtual void dispose(const LifecycleStatus& key) = 0;
  virtual bool wait_acknowledged(std::chrono::milliseconds limit) = 0;

 protected:
  LifecycleSink() = default;
  LifecycleSink(const LifecycleSink&) = default;
  LifecycleSink& operator=(const LifecycleSink&) = default;
};

class Outbox {
 public:
  static constexpr std::chrono::milliseconds kPatient{250};
  static constexpr std::chrono::milliseconds kImpatient{10};

  /// Adds a transition. Any thread may call put(), which never waits for the sink.
  void put(const LifecycleStatus& status);
  void put_disposal(const LifecycleStatus& key);

  /// Sends the next transition. If there is none, waits for one, but at most for `limit`. Returns false if no
  /// transition was sent. Only the thread that uses the sink may call this.
  bool serve(LifecycleSink& sink, std::chrono::milliseconds limit);
  /// Makes serve() return if it is waiting.
  void wake();

 private:
  struct Entry {
    LifecycleStatus status;
    bool disposal = false;
  };
  void send(LifecycleSink& sink, const Entry& entry);

  std::mutex mutex_;
  std::condition_variable wanted_;
  std::deque<Entry> entries_;
  bool woken_ = false;
  // The keys of the samples that may not be acknowledged yet. Only the thread that calls serve() uses this
  // member.
  std::set<std::string> unacknowledged_;
  bool last_wait_failed_ = false;
};

}  // namespace takt::node
