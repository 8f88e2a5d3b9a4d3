// Passes arbitrary bytes to the packet filter as a packet from the network. The filter must not read beyond
// the packet. If the filter accepts a message, it must also accept the message with one more submessage in
// front, and must reject the message if it ends within the header of its first submessage.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <takt/core/check.hpp>
#include <takt/wire/rtps.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::size_t readable = takt::wire::readable_rtps({data, size});
  if (readable == 0) return 0;
  constexpr std::size_t kHeader = 20;
  TAKT_CHECK(size >= readable && readable >= kHeader);
  TAKT_CHECK(takt::wire::readable_rtps({data, readable}) == readable);
  // Fast DDS looks for statistics submessages at multiples of four bytes. The part that the filter accepts
  // must contain none.
  for (std::size_t at = kHeader; at + 4 <= readable;) {
    TAKT_CHECK(data[at] != 0x80);
    const bool little = (data[at + 1] & 1) != 0;
    const std::size_t first = data[at + 2];
    const std::size_t second = data[at + 3];
    const std::size_t length = little ? first | second << 8U : first << 8U | second;
    if (length == 0 && data[at] != 0x01 && data[at] != 0x09) break;
    at += 4 + ((length + 3) & ~std::size_t{3});
  }
  static_cast<void>(takt::wire::is_protected_rtps({data, readable}));
  std::vector<std::uint8_t> longer{data, data + size};
  // Inserts an INFO_DST submessage in front of the first submessage.
  longer.insert(longer.begin() + kHeader, {0x0e, 1, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  TAKT_CHECK(takt::wire::readable_rtps(longer) == readable + 16);
  // Cuts the message off within the header of its first submessage.
  for (std::size_t n = kHeader + 1; n < kHeader + 4 && n < size; ++n)
    TAKT_CHECK(takt::wire::readable_rtps({data, n}) == 0);
  return 0;
}
