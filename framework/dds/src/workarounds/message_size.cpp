#include "message_size.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>
#include <vector>

#include <fastdds/rtps/common/CDRMessage_t.h>
#include <fastdds/rtps/history/WriterHistory.h>
#include <fastdds/rtps/messages/RTPSMessageGroup.h>
#include <fastdds/rtps/writer/RTPSWriter.h>
#include <fastdds/rtps/writer/LocatorSelectorSender.hpp>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

/// The bytes that DDS Security adds to a message: SRTPS_PREFIX, SEC_BODY and SRTPS_POSTFIX.
constexpr std::uint32_t kProtection = 24 + 8 + 24;
/// The bytes of a message with one DATA_FRAG, without its payload: the header, INFO_SRC (only with DDS
/// Security), INFO_DST twice, INFO_TS, the fields of DATA_FRAG, and a parameter of the inline QoS.
constexpr std::uint32_t kAroundFragment = 20 + 24 + 16 + 16 + 12 + 36 + 32;
/// The bytes that DDS Security adds to an encrypted payload or submessage.
constexpr std::uint32_t kPayloadProtection = 60;
constexpr std::size_t kMostNear =
    4096;  // then all are forgotten; participants announce themselves again and again

std::atomic<bool> is_secured{false};
std::mutex mutex;
std::set<takt::wire::ParticipantNumber> all_near;

/// The bytes that are added to each message after Fast DDS has composed it.
std::uint32_t addition() { return is_secured ? kProtection : 0; }
/// The longest message that Fast DDS may compose for another machine.
std::uint32_t limit() { return takt::dds::kLongestFarMessage - addition(); }
/// The longest message of discovery, unless it consists of one announcement that is longer. Announcements
/// have about 400 bytes, so discovery also works over a path that drops IP packets above 576 bytes, and then
/// the participant can tell that longer packets do not arrive.
constexpr std::uint32_t kLongestAnnouncement = 576 - 28;

bool is_far(const rtps::GuidPrefix_t& participant) {
  takt::wire::ParticipantNumber number{};
  std::copy_n(participant.value, number.size(), number.begin());
  const std::lock_guard lock{mutex};
  return !all_near.contains(number);
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

/// The replaced functions of Fast DDS.
struct Originals {
  using Insert = bool(rtps::RTPSMessageGroup*, const rtps::GuidPrefix_t&, bool);
  using Split = void(rtps::WriterHistory*, rtps::CacheChange_t*);

  Insert* insert = takt::dds::replaced<Insert>(
      "_ZN8eprosima8fastrtps4rtps16RTPSMessageGroup17insert_submessageERKNS1_12GuidPrefix_tEb");
  Split* split = takt::dds::replaced<Split>(
      "_ZN8eprosima8fastrtps4rtps13WriterHistory13set_fragmentsEPNS1_13CacheChange_tE");
};

const Originals& originals() noexcept {
  static const Originals found;
  return found;
}

}  // namespace

namespace takt::dds {

void keep_messages_short(bool secured) noexcept {
  static_cast<void>(originals());
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

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Splits a sample into fragments. They may be long if all present readers are on this machine, and if no
// other reader gets the sample later.
void WriterHistory::set_fragments(CacheChange_t* sample) {
  bool is_long = announces(mp_writer->getGuid().entityId);
  if (!is_long && sample->serializedPayload.length > longest_payload() / 2 &&
      mp_writer->getAttributes().durabilityKind == VOLATILE) {
    LocatorSelectorSender& readers = mp_writer->get_general_locator_selector();
    const std::lock_guard lock{readers};
    is_long = std::ranges::none_of(
        readers.locator_selector.transport_starts(),
        [](const LocatorSelectorEntry* each) { return is_far(each->remote_guid.guidPrefix); });
  }
  high_mark_for_frag_ = is_long ? mp_writer->getMaxDataSize() : longest_payload();
  originals().split(this, sample);
}

// Appends the submessage that Fast DDS has composed to the message. Sends the message before, if it would
// become too long.
bool RTPSMessageGroup::insert_submessage(const GuidPrefix_t& to, bool is_big) {
  const std::vector<GuidPrefix_t>& receivers = sender_->remote_participants();
  const std::uint32_t longest =
      announces(endpoint_->getGuid().entityId) ? kLongestAnnouncement - addition() : limit();
  if (full_msg_->length > RTPSMESSAGE_HEADER_SIZE && full_msg_->length + submessage_msg_->length > longest &&
      (receivers.empty() || std::ranges::any_of(receivers, &is_far))) {
    flush_and_reset();
    add_info_dst_in_buffer(full_msg_, to);
  }
  return originals().insert(this, to, is_big);
}

}  // namespace eprosima::fastrtps::rtps
