// Lets two threads remove two participants with DDS Security at the same time. Only the source files of this
// room include this header.
//
// When Fast DDS 2.9.1 removes a participant's authentication, it deletes a timer while it holds the lock of
// all authentications. The deletion waits until no timer runs. If a timer removes another participant at that
// moment, because its lease has expired, this timer waits for the lock. So both threads wait for ever. This
// participant then handles no discovery any more, and all others treat it as lost.
#pragma once

namespace takt::dds {

/// Makes Fast DDS delete the timer of a removed authentication after it has released the lock. Ends the
/// process if a function of Fast DDS that deferred_timers.cpp replaces is missing. Call this function before
/// the participant of this process is created.
void defer_deletion_of_timers() noexcept;

}  // namespace takt::dds
