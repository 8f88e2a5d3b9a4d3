#include "resends.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>

#include <fastdds/rtps/writer/StatefulWriter.h>

#include <takt/os/clock.hpp>
#include <takt/os/network.hpp>
#include "../packet_filter.hpp"
#include "heartbeat_pace.hpp"
#include "replaced_function.hpp"
#include "soon_repeated.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;
using takt::Instant;

/// After this time without a request, the reader has probably left.
constexpr std::chrono::seconds kForgotten{3};
constexpr std::size_t kMostRequests = 4096;

/// The request of a reader for samples of a writer, or for fragments of one sample.
struct Request {
  takt::dds::ResendPace pace;
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
  const Instant now = takt::os::now();
  const takt::Nanoseconds round_trip = takt::dds::round_trip_to(std::get<1>(key).guidPrefix);
  const std::lock_guard lock{mutex};
  if (requests.size() == kMostRequests) requests.clear();
  Request& request = requests[key];
  request.heard = now;
  if (!request.pace.is_due(now, first, round_trip)) return false;
  if (!request.pace.is_stuck(now)) {
    request.obstacle.clear();
  } else if (request.obstacle.empty()) {
    request.obstacle = "IP packets of up to 1280 bytes do not reach " +
                       takt::os::in_dots(takt::dds::PacketFilter::sender()) + ", but shorter ones do";
    if (tell) tell(request.obstacle);
  }
  return true;
}

using Fragments = bool(rtps::StatefulWriter*, const rtps::GUID_t&, const rtps::GUID_t&, std::uint32_t,
                       const rtps::SequenceNumber_t&, rtps::FragmentNumberSet_t, bool&);

Fragments* replaced_fragments() noexcept {
  static Fragments* const found = takt::dds::replaced<Fragments>(
      "_ZN8eprosima8fastrtps4rtps14StatefulWriter17process_nack_fragERKNS1_6GUID_tES5_jRKNS1_"
      "16SequenceNumber_tENS0_11BitmapRangeIjNS0_12DiffFunctionIjEELj256EEERb");
  return found;
}

}  // namespace

namespace takt::dds {

void limit_resends(std::function<void(const std::string&)> to) {
  static_cast<void>(replaced_fragments());
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

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

bool StatefulWriter::process_nack_frag(const GUID_t& writer, const GUID_t& reader, std::uint32_t count,
                                       const SequenceNumber_t& sample, const FragmentNumberSet_t missing,
                                       bool& is_mine) {
  if (writer == m_guid && !is_due({writer, reader, sample.to64long()}, missing.base())) {
    is_mine = true;
    return true;
  }
  return replaced_fragments()(this, writer, reader, count, sample, missing, is_mine);
}

}  // namespace eprosima::fastrtps::rtps
