#include "disposed_keys.hpp"

#include <cstring>

#include <fastdds/rtps/history/WriterHistory.h>
#include <fastdds/rtps/messages/CDRMessage.h>
#include <fastdds/rtps/messages/RTPSMessageCreator.h>
#include <fastdds/rtps/writer/RTPSWriter.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

thread_local const std::vector<char>* sent = nullptr;

constexpr rtps::octet kKeyFlag = 0x08;
constexpr std::uint32_t kSubmessageHeader = 4;  // kind, flags, and two bytes for the size

using AddSubmessage = bool(rtps::CDRMessage_t*, const rtps::CacheChange_t*, rtps::TopicKind_t,
                           const rtps::EntityId_t&, bool, rtps::InlineQosWriter*, bool*);

AddSubmessage* original() noexcept {
  static AddSubmessage* const function = takt::dds::replaced<AddSubmessage>(
      "_ZN8eprosima8fastrtps4rtps18RTPSMessageCreator17addSubmessageDataEPNS1_12CDRMessage_tEPKNS1_"
      "13CacheChange"
      "_tENS1_11TopicKind_tERKNS1_10EntityId_tEbPNS1_15InlineQosWriterEPb");
  return function;
}

}  // namespace

namespace takt::dds {

void SentKey::install() noexcept { sent = &bytes_; }
SentKey::~SentKey() { sent = nullptr; }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Replaces a function of Fast DDS with one that also stores the key in a disposal or unregistration. So if
// the message is lost, it is sent again with the key. The buffer is large enough, because Fast DDS allocates
// it for the whole sample, which contains the key.
void WriterHistory::notify_writer(CacheChange_t* change,
                                  const std::chrono::time_point<std::chrono::steady_clock>& limit) {
  if (sent != nullptr && change->kind != ALIVE) {
    TAKT_CHECK(sent->size() <= change->serializedPayload.max_size);
    std::memcpy(change->serializedPayload.data, sent->data(), sent->size());
    change->serializedPayload.length = static_cast<std::uint32_t>(sent->size());
  }
  mp_writer->unsent_change_added_to_history(change, limit);
}

// Calls the replaced function of Fast DDS, which omits the stored key, and then appends the key.
bool RTPSMessageCreator::addSubmessageData(CDRMessage_t* message, const CacheChange_t* change,
                                           TopicKind_t topic, const EntityId_t& reader,
                                           bool expects_inline_qos, InlineQosWriter* inline_qos,
                                           bool* is_big) {
  octet* const header = message->buffer + message->pos;
  const std::uint32_t body = message->pos + kSubmessageHeader;
  if (!original()(message, change, topic, reader, expects_inline_qos, inline_qos, is_big)) return false;
  const SerializedPayload_t& key = change->serializedPayload;
  if (change->kind == ALIVE || topic != WITH_KEY || change->writerGUID.is_builtin() || key.length == 0)
    return true;
  bool fits = CDRMessage::addData(message, key.data, key.length);
  while (message->pos % 4 != 0) fits = fits && CDRMessage::addOctet(message, 0);
  const auto size = static_cast<std::uint16_t>(message->pos - body);
  header[1] |= kKeyFlag;
  std::memcpy(header + 2, &size, sizeof size);
  return fits;
}

}  // namespace eprosima::fastrtps::rtps
