// Sends each announcement of this participant once. Only the source files of this room include this header.
//
// Fast DDS 2.9.1 sends an announcement to the addresses of all known participants, and then to the addresses
// at which unknown ones may be. With multicast, both are the same group.
#pragma once

namespace takt::dds {

/// Finds the function of Fast DDS that announced_once.cpp replaces; ends the process if it is missing. Call
/// this function before the participant of this process is created.
void announce_once() noexcept;

}  // namespace takt::dds
