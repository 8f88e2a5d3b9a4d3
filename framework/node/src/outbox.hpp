// The order in which lifecycle transitions go out.
//
// The topic keeps the last sample of each module, so that who joins late gets the present state and no more.
// But then a module that goes through two states at once overwrites the first before a reader on a busy
// machine has it. So a second sample of a module waits until the first was acknowledged; samples of other
// modules do not. A reader that has died and whose lease still runs acknowledges nothing: the wait is
// bounded, and short while it has lately been in vain.
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

/// Where transitions go: a dds::Writer, and in a test what reads along. One thread.
class LifecycleLine {
 public:
  virtual ~LifecycleLine() = default;
  virtual bool write(const LifecycleStatus& status) = 0;
  virtual void dispose(const LifecycleStatus& key) = 0;
  virtual bool wait_acknowledged(std::chrono::milliseconds limit) = 0;

 protected:
  LifecycleLine() = default;
  LifecycleLine(const LifecycleLine&) = default;
  LifecycleLine& operator=(const LifecycleLine&) = default;
};

class Outbox {
 public:
  static constexpr std::chrono::milliseconds kPatient{250};
  static constexpr std::chrono::milliseconds kImpatient{10};

  /// Any thread; never waits for the line.
  void put(const LifecycleStatus& status);
  void put_disposal(const LifecycleStatus& key);

  /// On the thread that serves the line: sends what is there, in order, or waits at most `limit` for
  /// something. False when nothing came.
  bool serve(LifecycleLine& line, std::chrono::milliseconds limit);
  /// Ends a wait of serve().
  void wake();

 private:
  struct Entry {
    LifecycleStatus status;
    bool disposal = false;
  };
  void send(LifecycleLine& line, const Entry& entry);

  std::mutex mutex_;
  std::condition_variable wanted_;
  std::deque<Entry> entries_;
  bool woken_ = false;
  std::set<std::string> unacknowledged_;  // keys; of the serving thread
  bool in_vain_ = false;
};

}  // namespace takt::node
