// Observes the cells of a domain from a program outside these cells.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/participant.hpp>
#include <takt/wire/cell_state.hpp>

namespace takt::client {

/// If this program discovers no new node for this time, it has usually discovered all nodes, even nodes that
/// no other node names in its report.
inline constexpr std::chrono::milliseconds kQuiet{600};

/// Holds the latest status of every discovered device and its modules. The observer receives a node's present
/// state as soon as it has discovered the node. Any thread may call the observer's functions.
class Observer {
 public:
  /// The callbacks. Fast DDS calls them on its own threads, never two at the same time. The callbacks must be
  /// short and must not call the observer.
  struct News {
    /// Called with a module's present state when the module's node is discovered, then with each new state in
    /// order.
    std::function<void(const LifecycleStatus&)> module{};
    /// Called when a device is found, is lost, comes back or changes its status. Not called if only the
    /// sequence number and the time of the status change.
    std::function<void(const wire::ObservedDevice&)> device{};
  };
  struct Options {
    News news{};
    bool statistics = false;  ///< true: also observe the statistics of modules and executors, and the
                              ///< status of ports
  };
  static Result<std::unique_ptr<Observer>> create(std::shared_ptr<dds::Participant> participant,
                                                  Options options);
  static Result<std::unique_ptr<Observer>> create(std::shared_ptr<dds::Participant> participant) {
    return create(std::move(participant), Options{});
  }
  ~Observer();

  /// Returns all devices, as wire::CellState::devices() does.
  [[nodiscard]] std::vector<wire::ObservedDevice> devices() const;
  [[nodiscard]] std::vector<wire::ObservedDevice> devices(const std::string& name) const;

  /// Waits until `condition` returns true for the devices, but at most for `limit`. Returns true if
  /// `condition` has returned true. Calls `condition` at every change and at least every 20 ms. `condition`
  /// may call the observer.
  bool wait(const std::function<bool(const std::vector<wire::ObservedDevice>&)>& condition,
            Nanoseconds limit) const;
  /// Waits until the observer has discovered no new node for kQuiet, because discovery is then probably
  /// complete. Waits at most for `limit`.
  void settle(Nanoseconds limit) const;

 private:
  struct Readers;
  explicit Observer(Options options);
  void receive(const DeviceStatus& status, wire::WriterId writer);
  void changed(const std::function<void(wire::CellState&)>& change);

  Options options_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  wire::CellState cell_state_;
  // Must be the last member: it is destroyed first, so that no callback uses members that are already
  // destroyed.
  std::unique_ptr<Readers> readers_;
};

}  // namespace takt::client
