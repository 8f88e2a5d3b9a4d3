// The cycle for which a thread currently calls a hook. takt_cycle(), takt_release_ns() and takt_period_ns()
// have no arguments, so they take their results from this cycle.
#pragma once

#include <takt/component.hpp>

namespace takt {

/// Sets the cycle for which this thread calls hooks from now on, and the ring for its log lines; null: none.
/// The cycle and the ring must stay valid until the next call of this function. For hooks other than run()
/// and condition(), only `start` and `period` (the module's own) of the cycle are set. A real-time thread may
/// call this.
void serve_cycle(const Cycle* cycle, channel::LogRing* log = nullptr) noexcept;
/// Returns the cycle for which this thread calls a hook; null if it calls none. A real-time thread may call
/// it.
const Cycle* served_cycle() noexcept;

/// While an object of this class exists, this thread constructs a component. A component may construct ports,
/// properties and Saved members only then; see detail::report_late().
class ConstructingComponent {
 public:
  ConstructingComponent() noexcept;
  ~ConstructingComponent();
  ConstructingComponent(const ConstructingComponent&) = delete;
  ConstructingComponent& operator=(const ConstructingComponent&) = delete;
};

}  // namespace takt
