// What goes on in the cells of a domain, for a program that is no part of them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/cell_state.hpp>
#include <takt/dds/participant.hpp>

namespace takt::client {

/// A node of which no other node told has usually been discovered this long after the one before it.
inline constexpr std::chrono::milliseconds kQuiet{600};

/// Every device and module, from the moment on that its node was found; who comes late is told the present
/// state at once. Any thread.
class Observer {
 public:
  /// Called one at a time, on threads of Fast DDS: not to take long, and not to ask the observer.
  struct News {
    /// A module's state: each transition, in order, and the present one of modules that were there before.
    std::function<void(const LifecycleStatus&)> module{};
    /// A device's status changed in something else than its number and time, or it was lost, or it came back.
    std::function<void(const dds::ObservedDevice&)> device{};
  };
  struct Options {
    News news{};
    bool statistics = false;  ///< modules', executors' and ports' too
  };
  static Result<std::unique_ptr<Observer>> create(std::shared_ptr<dds::Participant> participant,
                                                  Options options);
  static Result<std::unique_ptr<Observer>> create(std::shared_ptr<dds::Participant> participant) {
    return create(std::move(participant), Options{});
  }
  ~Observer();

  /// As dds::CellState.
  [[nodiscard]] std::vector<dds::ObservedDevice> devices() const;
  [[nodiscard]] std::vector<dds::ObservedDevice> devices(const std::string& name) const;

  /// Waits until `condition` holds of the devices, at most `limit`. Looks whenever something changed, and
  /// every few milliseconds. The condition may ask the observer.
  bool wait(const std::function<bool(const std::vector<dds::ObservedDevice>&)>& condition,
            Nanoseconds limit) const;
  /// Waits until whoever is there should have been found: no node came for a while, or none at all for
  /// `limit`.
  void settle(Nanoseconds limit) const;

 private:
  struct Readers;
  explicit Observer(Options options);
  void heard(const DeviceStatus& status, dds::WriterId writer);
  void changed(const std::function<void(dds::CellState&)>& change);

  Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  dds::CellState cell_state_;
  std::unique_ptr<Readers> readers_;  // last: nothing is heard after it is gone
};

}  // namespace takt::client
