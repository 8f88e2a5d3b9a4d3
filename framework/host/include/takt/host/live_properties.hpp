// Sets properties of a component while it runs, between two of its calls.
//
// The setting thread checks the texts and stores the new values aside. The thread that makes the next call
// of the component first takes over all of them together, so no value changes during a call. A module that is
// not running needs nothing else: it takes the values over at its next call. The real-time side reads one
// word; if values are waiting, it swaps them in. The setting thread frees the old values.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <takt/component/property.hpp>

namespace takt::host {

class LiveProperties {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;

  /// Serves the properties of the component `name`; an empty list ends that. Call it first, and while no hook
  /// is being called.
  void serve(std::vector<PropertyBase*> properties, std::string name);

  /// Sets all of them or none: one problem for each property that the component does not have or whose value
  /// it does not accept. They take effect at the component's next call. One thread at a time; may wait for a
  /// take_over() in progress.
  Result<void> set(const Values& values);
  /// The value that was set last. Only for the setting thread.
  [[nodiscard]] Result<std::string> get(const std::string& name) const;

  /// For the thread that is about to call the component, one thread at a time. Real-time safe.
  void take_over() noexcept {
    if (state_.load(std::memory_order_relaxed) == State::waiting) take_over_waiting();
  }

 private:
  enum class State : std::uint32_t { none, waiting, taken_over };

  [[nodiscard]] Result<PropertyBase*> find(const std::string& name) const;
  void withdraw();
  void take_over_waiting() noexcept;

  std::vector<PropertyBase*> properties_;
  std::string name_;
  std::vector<PropertyBase*> waiting_;  // owned by the setting thread, except while waiting or taken over
  // SYNC: values wait. The setting thread changes none to waiting, and back to none. The calling thread
  // changes waiting to taken_over, if it is first, and then to none.
  std::atomic<State> state_{State::none};
};

}  // namespace takt::host
