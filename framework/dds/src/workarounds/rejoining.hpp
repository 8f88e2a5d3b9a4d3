// Lets this process leave the domain and join it again, after the process was halted. Only the source files of
// this room include this header.
//
// Participants that hear nothing of a halted one for the lease forget it. But the halted one does not forget
// them, because their announcements wait in its socket. With DDS Security, Fast DDS 2.9.1 then never
// authenticates the two again: one side begins a new authentication, and the other side ignores it, because it
// has already authenticated its partner. So they do not communicate again until one of them ends.
#pragma once

#include "filtered_transport.hpp"

namespace takt::dds {

/// Finds the function of Fast DDS that rejoining.cpp replaces; ends the process if it is missing. Call this
/// function before the participant of this process is created.
void prepare_to_rejoin() noexcept;
/// Makes the participant of this process forget all others and be forgotten by them, and announces it again.
/// For half a second in between, the process neither sends nor receives anything. The listeners report that the
/// others are lost and found again. Any thread but a real-time one may call this function while the participant
/// exists.
void rejoin(PacketFilter& filter);

}  // namespace takt::dds
