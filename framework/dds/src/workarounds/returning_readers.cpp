#include "returning_readers.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>

#include "replaced_function.hpp"
#include "resends.hpp"
#include "soon_repeated.hpp"

#define ACKNACK                                                                                    \
  TAKT_RTPS                                                                                        \
  "14StatefulWriter15process_acknackERKNS1_6GUID_tES5_jRKNS0_11BitmapRangeINS1_16SequenceNumber_t" \
  "ENS1_18SequenceNumberDiffELj256EEEbRb" TAKT_VENDOR

namespace takt::dds {

namespace {

// Readers that have ended leave their number behind. If there are so many, all are learned again.
constexpr std::size_t kMostReaders = 4096;

std::mutex mutex;
// The number before which a reader has acknowledged all samples of a writer, by writer and reader.
std::map<std::pair<rtps::GUID_t, rtps::GUID_t>, rtps::SequenceNumber_t> acknowledged;

/// Returns true if the reader requests samples that it has acknowledged before.
bool is_returning(const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                  const rtps::SequenceNumberSet_t& requested) {
  const std::lock_guard lock{mutex};
  if (acknowledged.size() >= kMostReaders) acknowledged.clear();
  rtps::SequenceNumber_t& before = acknowledged[{writer, reader}];
  if (requested.empty()) {
    before = std::max(before, requested.base());
    return false;
  }
  return requested.base() < std::exchange(before, requested.base());
}

/// Handles a request of a reader. `handle` passes the samples that the writer should send, and whether the
/// reader wants no answer, to Fast DDS. Fast DDS asks each writer of the participant.
template <class Handle>
bool answer(const void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
            const rtps::SequenceNumberSet_t& requested, bool final, Handle&& handle) {
  if (guid_of(object) != writer) return handle(requested, final);
  // A reader that has not received a heartbeat yet sends number 0.
  if (requested.base() > rtps::SequenceNumber_t{}) {
    heartbeat_answered(writer, reader);
    if (is_returning(writer, reader, requested))
      return handle(rtps::SequenceNumberSet_t{rtps::SequenceNumber_t{}}, false);
  }
  if (!may_answer(writer, reader, requested))  // only the acknowledgement counts
    return handle(rtps::SequenceNumberSet_t{requested.base()}, true);
  return handle(requested, final);
}

#if TAKT_FASTDDS == 2
using Acknack = bool(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                     std::uint32_t count, const rtps::SequenceNumberSet_t& requested, bool final,
                     bool& is_mine);
#else
using Acknack = bool(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                     std::uint32_t count, const rtps::SequenceNumberSet_t& requested, bool final,
                     bool& is_mine, std::array<std::uint8_t, 2> vendor);
#endif

Acknack* original() noexcept {
  static Acknack* const found = replaced<Acknack>(ACKNACK);
  return found;
}

}  // namespace

void send_again_to_returning_readers() noexcept { static_cast<void>(original()); }

Acknack process_acknack asm(ACKNACK);

#if TAKT_FASTDDS == 2
bool process_acknack(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                     std::uint32_t count, const rtps::SequenceNumberSet_t& requested, bool final,
                     bool& is_mine) {
  return answer(object, writer, reader, requested, final, [&](const auto& samples, bool is_final) {
    return original()(object, writer, reader, count, samples, is_final, is_mine);
  });
}
#else
bool process_acknack(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                     std::uint32_t count, const rtps::SequenceNumberSet_t& requested, bool final,
                     bool& is_mine, std::array<std::uint8_t, 2> vendor) {
  return answer(object, writer, reader, requested, final, [&](const auto& samples, bool is_final) {
    return original()(object, writer, reader, count, samples, is_final, is_mine, vendor);
  });
}
#endif

}  // namespace takt::dds
