// Wakes another process by a signal, as the scheduler of the paper does. Takt itself uses no wake signal;
// only its benchmarks do, for comparison.
#pragma once

namespace takt::os {

/// Blocks the wake signal (SIGRTMIN) for the calling thread and for threads that it starts later. If the
/// signal arrives, it stays pending until a thread waits for it.
void hold_wake_signal() noexcept;
/// Sleeps until the wake signal arrives. One system call.
void wait_for_wake_signal() noexcept;
/// Sends the wake signal to this process. One system call.
void send_wake_signal(int pid) noexcept;

}  // namespace takt::os
