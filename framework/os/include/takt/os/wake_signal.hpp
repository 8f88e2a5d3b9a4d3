// Wakes another process by a signal, as the scheduler of the paper does. Takt itself does not use this; only
// its benchmarks do, for comparison.
#pragma once

namespace takt::os {

/// Blocks the signal for this thread and for threads that it starts later. A signal that arrives then stays
/// pending until a thread waits for it.
void hold_wake_signal() noexcept;
/// Sleeps until the signal arrives. One system call.
void wait_for_wake_signal() noexcept;
/// Sends the signal. One system call.
void send_wake_signal(int pid) noexcept;

}  // namespace takt::os
