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
  std::vector<std::uint8_t> longer{data, data + size};
  // An INFO_DST in front of the others.
  longer.insert(longer.begin() + kHeader, {0x0e, 1, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  TAKT_CHECK(takt::dds::readable_rtps(longer) == readable + 16);
  // Not all of its last submessage.
  for (std::size_t n = kHeader + 1; n < kHeader + 4 && n < size; ++n)
    TAKT_CHECK(takt::dds::readable_rtps({data, n}) == 0);
  return 0;
}
