// What is an RTPS message at all (DDSI-RTPS 2.5, 9.4). Fast DDS reads on where a stranger's message says so,
// and some of them end it: this version frees what it never had for a DATA_FRAG without content
// (CVE-2023-50716), and breaks off where its own statistics are not as it would have sent them. So each
// message is held against the specification before it sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::dds {

/// Every submessage has what its kind must have, within its own length; lists of parameters end, and so does
/// what they count. That says nothing about who sent it, or whether it makes sense. Bytes of the message that
/// are to be read: statistics at its end are for nobody here. 0: it is none. Any thread; does not allocate.
[[nodiscard]] std::size_t readable_rtps(std::span<const std::uint8_t> message) noexcept;

}  // namespace takt::dds
