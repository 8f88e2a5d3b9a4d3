// Waking another process by a signal, as the scheduler of the paper does. Takt's own does not: it is here to
// be measured against.
#pragma once

namespace takt::os {

/// The signal is kept until somebody waits for it, in this thread and those that it starts later.
void hold_wake_signal() noexcept;
/// Sleeps until it has come. One system call.
void wait_for_wake_signal() noexcept;
/// One system call.
void send_wake_signal(int pid) noexcept;

}  // namespace takt::os
