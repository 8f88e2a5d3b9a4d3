// Repeats lost messages of discovery and authentication soon, and adapts heartbeats to slow readers
// (heartbeat_pace.hpp). Only the source files of this room include this header.
//
// In Fast DDS 2.9.1, the writers of discovery send a heartbeat every second, and answer a request for a lost
// message after 100 ms. The writer of the keys of DDS Security sends one every 3 s, and an authentication
// message is repeated after a second. So on a network that loses packets, a new participant needs several
// seconds to find the others. The times are constants.
#pragma once

#include <takt/core/time.hpp>
#include "../fast_dds.hpp"

namespace takt::dds {

/// Finds the functions of Fast DDS that soon_repeated.cpp replaces; ends the process if one is missing. Call
/// this function before the participant of this process is created.
void repeat_lost_messages_soon() noexcept;

/// The reader has answered a heartbeat of the writer.
void heartbeat_answered(const rtps::GUID_t& writer, const rtps::GUID_t& reader);

/// Returns how long the answers of this participant take, at least; 0: not known yet.
Nanoseconds round_trip_to(const rtps::GuidPrefix_t& participant);

}  // namespace takt::dds
