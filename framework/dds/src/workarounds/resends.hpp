// Limits how often a writer sends the same samples to the same reader again. In Fast DDS 2.9.1, a reader
// requests all samples that it misses whenever a heartbeat arrives, every 5 to 10 ms, and the writer sends
// all of them again. If a path never lets a sample through, for example because the path drops long packets,
// that is thousands of packets each second, without an end. This file makes the pause between two answers to
// the same request grow from 10 ms to 1 s, and tells which participant answers but receives nothing.
#pragma once

#include <functional>
#include <string>

#include <takt/core/time.hpp>
#include <takt/wire/rtps.hpp>
#include "../fast_dds.hpp"

namespace takt::dds {

/// Call this function once before the process creates a participant. `tell` gets a sentence about each
/// participant that a sample has not reached for 3 s, and may be called repeatedly. It may be empty.
void limit_resends(std::function<void(const std::string&)> tell);

/// Returns a sentence that says why samples do not reach this participant now, although it answers. Empty if
/// nothing indicates that.
[[nodiscard]] std::string obstacle_to(const wire::ParticipantNumber& participant);

/// Call this function for each ACKNACK. Returns true if the writer may send the missing samples again now.
[[nodiscard]] bool may_answer(const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                              const rtps::SequenceNumberSet_t& missing);

/// Returns true if may_answer() would reject everything that the reader has requested and still misses, also
/// if the request came `within` this time. A heartbeat would only cause such a request.
[[nodiscard]] bool is_answer_paused(const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                                    Nanoseconds within);

}  // namespace takt::dds
