// Arbitrary bytes as a packet of the network. Who reads it first reads nothing that is not there; what is let
// through is let through with another message's submessages behind it, and a part of it only where a
// submessage ends.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <takt/core/check.hpp>
#include <takt/dds/rtps.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::size_t readable = takt::dds::readable_rtps({data, size});
  if (readable == 0) return 0;
  constexpr std::size_t kHeader = 20;
  TAKT_CHECK(size >= readable && readable >= kHeader);
  TAKT_CHECK(takt::dds::readable_rtps({data, readable}) == readable);
  // Where Fast DDS looks for its statistics, from one multiple of four to the next, there are none.
  for (std::size_t at = kHeader; at + 4 <= readable;) {
    TAKT_CHECK(data[at] != 0x80);
    const bool little = (data[at + 1] & 1) != 0;
    const std::size_t first = data[at + 2];
    const std::size_t second = data[at + 3];
    const std::size_t length = little ? first | second << 8U : first << 8U | second;
    if (length == 0 && data[at] != 0x01 && data[at] != 0x09) break;
    at += 4 + ((length + 3) & ~std::size_t{3});
  }
  static_cast<void>(takt::dds::is_protected_rtps({data, readable}));
  std::vector<std::uint8_t> longer{data, data + size};
  // An INFO_DST in front of the others.
  longer.insert(longer.begin() + kHeader, {0x0e, 1, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  TAKT_CHECK(takt::dds::readable_rtps(longer) == readable + 16);
  // Not all of its last submessage.
  for (std::size_t n = kHeader + 1; n < kHeader + 4 && n < size; ++n)
    TAKT_CHECK(takt::dds::readable_rtps({data, n}) == 0);
  return 0;
}
