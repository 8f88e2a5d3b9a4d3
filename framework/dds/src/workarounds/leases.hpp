// Renews the lease of a writer without waking a thread. Only the source files of this room include this
// header.
//
// Fast DDS 2.9.1 has one timer for the leases of all writers. Each sample of a writer cancels this timer and
// starts it again, which wakes the thread of the timers twice, and goes through the list of all writers,
// locking a mutex for each. Ten samples a second of each of 32 devices took a quarter of a node's CPU time.
#pragma once

namespace takt::dds {

/// Finds the functions of Fast DDS that leases.cpp replaces; ends the process if one is missing. Call this
/// function before the participant of this process is created.
void renew_leases_quietly() noexcept;

}  // namespace takt::dds
