#include "resends.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>

#include <takt/os/clock.hpp>
#include <takt/os/network.hpp>
#include "../packet_filter.hpp"
#include "heartbeat_pace.hpp"
#include "replaced_function.hpp"
#include "soon_repeated.hpp"

#if TAKT_FASTDDS == 2
#define REFERENCE_TO ""
#else
#define REFERENCE_TO "RK"
#endif
#define FRAGMENTS                                                                                \
  TAKT_RTPS                                                                                      \
  "14StatefulWriter17process_nack_fragERKNS1_6GUID_tES5_jRKNS1_16SequenceNumber_tE" REFERENCE_TO \
  "NS0_11BitmapRangeIjNS0_12DiffFunctionIjEELj256EEERb" TAKT_VENDOR

namespace takt::dds {

namespace {

/// After this time without a request, the reader has probably left.
constexpr std::chrono::seconds kForgotten{3};
constexpr std::size_t kMostRequests = 4096;

/// The request of a reader for samples of a writer, or for fragments of one sample.
struct Request {
  ResendPace pace;
  Instant heard{};
  std::string obstacle;
};
/// The writer, the reader, and the number of the sample of which fragments are missing, or 0.
using Key = std::tuple<rtps::GUID_t, rtps::GUID_t, std::uint64_t>;

std::mutex mutex;
std::map<Key, Request> requests;
std::function<void(const std::string&)> tell;

/// Returns true if the writer may answer this request now.
bool is_due(const Key& key, std::uint64_t first) {
  const Instant now = os::now();
  const Nanoseconds round_trip = round_trip_to(std::get<1>(key).guidPrefix);
  const std::lock_guard lock{mutex};
  if (requests.size() == kMostRequests) requests.clear();
  Request& request = requests[key];
  request.heard = now;
  if (!request.pace.is_due(now, first, round_trip)) return false;
  if (!request.pace.is_stuck(now)) {
    request.obstacle.clear();
  } else if (request.obstacle.empty()) {
    request.obstacle = "IP packets of up to 1280 bytes do not reach " + os::in_dots(PacketFilter::sender()) +
                       ", but shorter ones do";
    if (tell) tell(request.obstacle);
  }
  return true;
}

#if TAKT_FASTDDS == 2
using Answer = bool(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader, std::uint32_t count,
                    const rtps::SequenceNumber_t& sample, rtps::FragmentNumberSet_t missing, bool& is_mine);
#else
using Answer = bool(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader, std::uint32_t count,
                    const rtps::SequenceNumber_t& sample, const rtps::FragmentNumberSet_t& missing,
                    bool& is_mine, std::array<std::uint8_t, 2> vendor);
#endif

Answer* original() noexcept {
  static Answer* const found = replaced<Answer>(FRAGMENTS);
  return found;
}

}  // namespace

void limit_resends(std::function<void(const std::string&)> to) {
  static_cast<void>(original());
  const std::lock_guard lock{mutex};
  tell = std::move(to);
}

std::string obstacle_to(const wire::ParticipantNumber& participant) {
  const std::lock_guard lock{mutex};
  for (const auto& [key, request] : requests) {
    const auto& prefix = std::get<1>(key).guidPrefix.value;
    if (std::equal(participant.begin(), participant.end(), prefix) && !request.obstacle.empty() &&
        os::now() - request.heard < kForgotten)
      return request.obstacle;
  }
  return {};
}

bool may_answer(const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                const rtps::SequenceNumberSet_t& missing) {
  const std::uint64_t first = missing.base().to64long();
  {
    const std::lock_guard lock{mutex};
    if (requests.empty() && missing.empty()) return true;
    // The reader has all samples before the first missing one.
    requests.erase(requests.upper_bound({writer, reader, 0}),
                   requests.lower_bound({writer, reader, std::max<std::uint64_t>(first, 1)}));
    if (missing.empty()) requests.erase({writer, reader, 0});
  }
  return missing.empty() || is_due({writer, reader, 0}, first);
}

bool is_answer_paused(const rtps::GUID_t& writer, const rtps::GUID_t& reader, Nanoseconds within) {
  const Instant now = os::now();
  const std::lock_guard lock{mutex};
  auto each = requests.lower_bound({writer, reader, 0});
  const auto end = requests.upper_bound({writer, reader, std::numeric_limits<std::uint64_t>::max()});
  return each != end &&
         std::all_of(each, end, [&](const auto& one) { return one.second.pace.is_paused(now, within); });
}

Answer process_nack_frag asm(FRAGMENTS);

#if TAKT_FASTDDS == 2
bool process_nack_frag(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                       std::uint32_t count, const rtps::SequenceNumber_t& sample,
                       rtps::FragmentNumberSet_t missing, bool& is_mine) {
  is_mine = guid_of(object) == writer;
  return (is_mine && !is_due({writer, reader, sample.to64long()}, missing.base())) ||
         original()(object, writer, reader, count, sample, missing, is_mine);
}
#else
bool process_nack_frag(void* object, const rtps::GUID_t& writer, const rtps::GUID_t& reader,
                       std::uint32_t count, const rtps::SequenceNumber_t& sample,
                       const rtps::FragmentNumberSet_t& missing, bool& is_mine,
                       std::array<std::uint8_t, 2> vendor) {
  is_mine = guid_of(object) == writer;
  return (is_mine && !is_due({writer, reader, sample.to64long()}, missing.base())) ||
         original()(object, writer, reader, count, sample, missing, is_mine, vendor);
}
#endif

}  // namespace takt::dds
