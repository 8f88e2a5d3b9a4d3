// Makes the readers of Fast DDS check the numbers in HEARTBEAT, GAP and DATA_FRAG. The packet filter cannot
// check these numbers: whether a number is valid depends on earlier packets, and with DDS Security it is
// encrypted. Only the source files of this room include this header.
//
// - Fast DDS 2.9.1 counts one by one up to the first number of a HEARTBEAT, and holds a lock meanwhile
//   (CVE-2025-65016). It does the same when a reader matches a writer that has written for months.
// - It stores each number of a GAP (CVE-2025-64438).
// - It takes the size of a sample and of its fragments from the first DATA_FRAG, and does not compare the
//   sizes in later ones (CVE-2026-22590). It writes past the end of a sample whose last fragment is shorter
//   than 4 bytes (CVE-2025-62799). It allocates memory for samples of any claimed size.
// - It handles a sample whose fragments all arrive at once twice, the second time after it has freed the
//   sample. It also keeps two samples with the same number, if one arrives in fragments and the other does
//   not. Then an assertion fails, or the thread that receives packets never returns.
// - It stores an incomplete sample under the key hash that a fragment contains, and uses its memory again
//   while it is still there. Then a thread takes the same sample for ever.
// - It presents an incomplete sample to the listener if the list of a GAP contains its number. Then an
//   assertion fails.
// - It never frees a sample that it drops because as many newer samples of the same key are waiting as it
//   keeps.
#pragma once

#include <cstdint>

namespace takt::dds {

/// Finds the functions of Fast DDS that reader_checks.cpp replaces; ends the process if one is missing. Call
/// this function before the participant of this process is created.
void check_what_readers_receive() noexcept;

/// Returns how many samples and fragments the readers of this process have ignored, because they are too
/// long, contradict each other or are too many.
std::uint64_t refused_by_readers() noexcept;

}  // namespace takt::dds
