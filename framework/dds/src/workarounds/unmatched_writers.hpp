// Locks a reader while it forgets a writer that has ended. Only the source files of this room include this
// header.
//
// When a writer is deleted or its participant leaves, Fast DDS 2.9.1 removes it from the reader's list of live
// writers without the lock of the reader. If a sample for the reader arrives at that moment, another thread
// reads the list, and the process may crash.
#pragma once

namespace takt::dds {

/// Finds the function of Fast DDS that unmatched_writers.cpp replaces; ends the process if it is missing. Call
/// this function before the participant of this process is created.
void lock_readers_that_lose_writers() noexcept;

}  // namespace takt::dds
