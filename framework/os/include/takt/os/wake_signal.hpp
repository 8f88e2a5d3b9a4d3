// Wakes another process by a signal, as the scheduler of the paper does. Takt does not use this; benchmarks
// compare against it.
#pragma once

namespace takt::os {

/// Blocks the signal for this thread and for threads that it starts later, so that it is pending until it is
/// waited for.
void hold_wake_signal() noexcept;
/// Sleeps until the signal arrives. One system call.
void wait_for_wake_signal() noexcept;
/// Sends the signal. One system call.
void send_wake_signal(int pid) noexcept;

}  // namespace takt::os
