#include "message_size.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/os/clock.hpp>
#include "message_group.hpp"
#include "replaced_function.hpp"

#if TAKT_FASTDDS == 2
#include <fastdds/rtps/common/CDRMessage_t.h>
#include <fastdds/rtps/history/WriterHistory.h>
#include <fastdds/rtps/messages/RTPSMessageGroup.h>
#else
#include <fastdds/rtps/common/CDRMessage_t.hpp>
#include <fastdds/rtps/history/WriterHistory.hpp>
#endif

#define SPLIT TAKT_RTPS "13WriterHistory13set_fragmentsEPNS1_13CacheChange_tE"
#define INSERT TAKT_RTPS "16RTPSMessageGroup17insert_submessageERKNS1_12GuidPrefix_tEb"
#define FITS TAKT_RTPS "16RTPSMessageGroup11check_spaceEPNS1_12CDRMessage_tEj"

namespace {

namespace rtps = takt::dds::rtps;

/// The bytes that DDS Security adds to a message: SRTPS_PREFIX, SEC_BODY and SRTPS_POSTFIX.
constexpr std::uint32_t kProtection = 24 + 8 + 24;
/// The bytes of a message with one DATA_FRAG, without its payload: the header, INFO_SRC (only with DDS
/// Security), INFO_DST twice, INFO_TS, the fields of DATA_FRAG, and a parameter of the inline QoS.
constexpr std::uint32_t kAroundFragment = 20 + 24 + 16 + 16 + 12 + 36 + 32;
/// The bytes that DDS Security adds to an encrypted payload or submessage.
constexpr std::uint32_t kPayloadProtection = 60;
constexpr std::size_t kMostNear =
    4096;  // then all are forgotten; participants announce themselves again and again
/// Each participant sends something more often.
constexpr takt::Nanoseconds kSendsOnce = std::chrono::seconds{10};

std::atomic<bool> is_secured{false};
std::mutex mutex;
std::set<takt::wire::ParticipantNumber> all_near;
std::atomic<takt::Instant> last_from_afar{};

/// The bytes that are added to each message after Fast DDS has composed it.
std::uint32_t addition() { return is_secured ? kProtection : 0; }
/// The longest message that Fast DDS may compose for another machine.
std::uint32_t limit() { return takt::dds::kLongestFarMessage - addition(); }
/// The longest message of discovery, unless it consists of one announcement that is longer. Announcements
/// have about 400 bytes, so discovery also works over a path that drops IP packets above 576 bytes, and then
/// the participant can tell that longer packets do not arrive.
constexpr std::uint32_t kLongestAnnouncement = 576 - 28;

bool is_far(const rtps::GuidPrefix_t& participant) {
  return !takt::dds::is_near(takt::dds::number_in(participant));
}

/// The longest payload of a fragment for another machine.
std::uint32_t longest_payload() {
  return (limit() - kAroundFragment - (is_secured ? kPayloadProtection : 0)) & ~3U;
}

/// Announcements cannot be split: readers of participants' announcements know no writer yet, and receivers
/// check announcements before Fast DDS assembles them (wire/rtps.hpp).
bool announces(const rtps::EntityId_t& writer) {
  return writer == rtps::c_EntityId_SPDPWriter || writer == rtps::c_EntityId_SEDPPubWriter ||
         writer == rtps::c_EntityId_SEDPSubWriter;
}

/// Returns true if a message of this writer or reader must be sent before it becomes so long.
bool is_too_long(std::uint32_t length, const rtps::EntityId_t& from,
                 const std::vector<rtps::GuidPrefix_t>& receivers) {
  return length > (announces(from) ? kLongestAnnouncement - addition() : limit()) &&
         (receivers.empty() || std::ranges::any_of(receivers, &is_far));
}

using Split = void(rtps::WriterHistory*, rtps::CacheChange_t*);
Split* split_original() noexcept {
  static Split* const found = takt::dds::replaced<Split>(SPLIT);
  return found;
}

#if TAKT_FASTDDS == 2
using Insert = bool(rtps::RTPSMessageGroup*, const rtps::GuidPrefix_t&, bool);
Insert* original() noexcept {
  static Insert* const found = takt::dds::replaced<Insert>(INSERT);
  return found;
}
#else
using Fits = bool(void*, rtps::CDRMessage_t*, std::uint32_t);
Fits* original() noexcept {
  static Fits* const found = takt::dds::replaced<Fits>(FITS);
  return found;
}
#endif

/// Names protected members.
struct History : rtps::WriterHistory {
  static auto writer() { return &History::mp_writer; }
  static auto longest() { return &History::high_mark_for_frag_; }  // 0: the default
};

}  // namespace

namespace takt::dds {

void keep_messages_short(bool secured) noexcept {
  static_cast<void>(split_original());
  static_cast<void>(original());
  is_secured = secured;
}

void set_near(const wire::ParticipantNumber& participant, bool near) {
  const std::lock_guard lock{mutex};
  if (all_near.size() == kMostNear) all_near.clear();
  if (near)
    all_near.insert(participant);
  else
    all_near.erase(participant);
}

bool is_near(const wire::ParticipantNumber& participant) {
  const std::lock_guard lock{mutex};
  return all_near.contains(participant);
}

void heard_from_afar() { last_from_afar.store(os::now(), std::memory_order_relaxed); }

// Splits a sample into fragments. They may be long if all participants are on this machine, and if no other
// reader gets the sample later.
Split split asm(SPLIT);
void split(rtps::WriterHistory* history, rtps::CacheChange_t* sample) {
  auto* const writer = reinterpret_cast<rtps::RTPSWriter*>(history->*History::writer());
  const bool all_near = os::now() - last_from_afar.load(std::memory_order_relaxed) > kSendsOnce;
  const bool is_long = announces(sample->writerGUID.entityId) ||
                       (all_near && writer->getAttributes().durabilityKind == rtps::VOLATILE);
  history->*History::longest() = is_long ? 0 : longest_payload();
  split_original()(history, sample);
}

#if TAKT_FASTDDS != 2
// Fast DDS has composed a submessage; with it, the message becomes longer by at most `more`. Returns false if
// Fast DDS must send the message before.
Fits fits asm(FITS);
bool fits(void* group, rtps::CDRMessage_t* message, std::uint32_t more) {
  const auto& [receivers, from] = message_group(group);
  return original()(group, message, more) &&
         (message->length <= RTPSMESSAGE_HEADER_SIZE ||
          !is_too_long(message->length + more, from->getGuid().entityId, receivers->remote_participants()));
}
#endif

}  // namespace takt::dds

#if TAKT_FASTDDS == 2
namespace eprosima::fastrtps::rtps {

// Appends the submessage that Fast DDS has composed to the message. Sends the message before, if it would
// become too long.
bool RTPSMessageGroup::insert_submessage(const GuidPrefix_t& to, bool is_big) {
  if (full_msg_->length > RTPSMESSAGE_HEADER_SIZE &&
      is_too_long(full_msg_->length + submessage_msg_->length, endpoint_->getGuid().entityId,
                  sender_->remote_participants())) {
    flush_and_reset();
    add_info_dst_in_buffer(full_msg_, to);
  }
  return original()(this, to, is_big);
}

}  // namespace eprosima::fastrtps::rtps
#endif
