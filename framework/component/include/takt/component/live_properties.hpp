// Sets properties of a component while it runs, between two calls of its functions.
//
// The setting thread checks the texts and stores the new values separately. The thread that next calls the
// component first takes over all waiting values together, so no value changes during a call. A module that is
// not running takes over the values in the same way, at its next call. The real-time thread reads one word;
// if values are waiting, it swaps them in. The setting thread frees the old values.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <takt/component/property.hpp>

namespace takt {

class LiveProperties {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;

  /// From now on, set() and get() refer to these properties of `owner`, which is the subject of messages:
  /// "component Drive". With an empty list, the owner has no properties any more. Call serve() before the
  /// other functions, and while no hook is being called.
  void serve(std::vector<PropertyBase*> properties, std::string owner);

  /// Sets all these properties or none. Fails with one problem for each property that the component does not
  /// have, and for each value that its property does not accept. The values take effect when the component is
  /// called next. Only one thread at a time may call set(). If another thread is in take_over(), set() waits
  /// for that thread.
  Result<void> set(const Values& values);
  /// Returns the value that was set last. Only the setting thread may call get().
  [[nodiscard]] Result<std::string> get(const std::string& name) const;

  /// Takes over the waiting values. Only the thread that is about to call the component may call this, one
  /// thread at a time. A real-time thread may call it.
  void take_over() noexcept {
    if (state_.load(std::memory_order_relaxed) == State::waiting) take_over_waiting();
  }

 private:
  enum class State : std::uint32_t { none, waiting, taken_over };

  [[nodiscard]] Result<PropertyBase*> find(const std::string& name) const;
  void withdraw();
  void take_over_waiting() noexcept;

  std::vector<PropertyBase*> properties_;
  std::string owner_;
  std::vector<PropertyBase*> waiting_;  // owned by the setting thread, except while the state is `waiting` or
                                        // `taken_over`
  // The setting thread changes `none` to `waiting`, and may change `waiting` back to `none`. The calling
  // thread changes `waiting` to `taken_over`, and then to `none`.
  std::atomic<State> state_{State::none};
};

}  // namespace takt
