// With DDS Security, a participant of Fast DDS 3 announces itself to another one a second time, encrypted,
// after their authentication, and each communicates with the other only after this second announcement. A
// participant of Fast DDS 2.9 claims to send one, too, but does not. So members with different versions would
// never communicate. Only the source files of this room include this header.
#pragma once

#include <takt/wire/rtps.hpp>
#include "../fast_dds.hpp"

namespace takt::dds {

#if TAKT_FASTDDS == 2
inline void prepare_for_old_members() noexcept {}
inline void note_member(const wire::ParticipantNumber&, bool) {}
#else
/// Finds the functions of Fast DDS that version_3.cpp replaces for members with Fast DDS 2.9; ends the
/// process if one is missing. Call this function before the participant of this process is created.
void prepare_for_old_members() noexcept;
/// Sets whether a participant announces itself only once. Call this function for each announcement, before
/// Fast DDS handles it.
void note_member(const wire::ParticipantNumber& participant, bool is_old);
#endif

}  // namespace takt::dds
