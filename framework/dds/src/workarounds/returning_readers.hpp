// Lets a reader that has lost and rediscovered a writer receive the writer's samples again. Only the source
// files of this room include this header.
//
// A participant that hears nothing of another one for the lease, for example because that process was halted,
// forgets it. If the other participant has not forgotten the first one, its writers still count their samples
// as acknowledged. A reader that finds such a writer again asks for everything with an ACKNACK of number 0.
// But Fast DDS 2.9.1 does not send this ACKNACK if a HEARTBEAT of the writer arrives first: then the reader
// asks for the single numbers, and the writer ignores the request for each number that it counts as
// acknowledged. The readers and writers of discovery itself work in this way, so the two participants do not
// communicate again until one of them ends.
#pragma once

namespace takt::dds {

/// Finds the function of Fast DDS that returning_readers.cpp replaces; ends the process if it is missing.
/// Call this function before the participant of this process is created.
void send_again_to_returning_readers() noexcept;

}  // namespace takt::dds
