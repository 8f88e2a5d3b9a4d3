#include "disposed_keys.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>

#include "replaced_function.hpp"

#define NOTIFY_WRITER                                                                                   \
  TAKT_RTPS                                                                                             \
  "13WriterHistory13notify_writerEPNS1_13CacheChange_tERKNSt6chrono10time_pointINS5_3_V212steady_clock" \
  "ENS5_8durationIlSt5ratioILl1ELl1000000000EEEEEE"
#define ADD_DATA                                                                                         \
  TAKT_RTPS                                                                                              \
  "18RTPSMessageCreator17addSubmessageDataEPNS1_12CDRMessage_tEPKNS1_13CacheChange_tENS1_11TopicKind_tE" \
  "RKNS1_10EntityId_tEbPNS1_15InlineQosWriterE"
#if TAKT_FASTDDS == 2
#include <fastdds/rtps/common/CDRMessage_t.h>
#include <fastdds/rtps/common/CacheChange.h>
#else
#include <fastdds/rtps/common/CDRMessage_t.hpp>
#include <fastdds/rtps/common/CacheChange.hpp>
#endif

namespace takt::dds {

namespace {

thread_local const std::vector<char>* sent = nullptr;

// A Fast DDS reader would interpret a key of up to 16 bytes as the hash of a key, and dispose of another
// sample. Readers ignore the zeros after the key.
constexpr std::size_t kShortest = 20;
constexpr rtps::octet kKeyFlag = 0x08;
constexpr std::uint32_t kSubmessageHeader = 4;  // kind, flags, and two bytes for the size

using NotifyWriter = void(void* history, rtps::CacheChange_t*, const std::chrono::steady_clock::time_point&);

NotifyWriter* original_notify() noexcept {
  static NotifyWriter* const found = replaced<NotifyWriter>(NOTIFY_WRITER);
  return found;
}

/// Lets `add` append a DATA submessage to a message, and then appends the stored key, which Fast DDS omits.
template <class Add>
bool add_with_key(rtps::CDRMessage_t& message, const rtps::CacheChange_t& change, rtps::TopicKind_t topic,
                  Add&& add) {
  rtps::octet* const header = message.buffer + message.pos;
  const std::uint32_t body = message.pos + kSubmessageHeader;
  if (!add()) return false;
  const rtps::SerializedPayload_t& key = change.serializedPayload;
  if (change.kind == rtps::ALIVE || topic != rtps::WITH_KEY || change.writerGUID.is_builtin() ||
      key.length == 0)
    return true;
  const std::uint32_t padded = (key.length + 3) / 4 * 4;
  if (padded > message.max_size - message.pos) return false;
  rtps::octet* const end = std::copy_n(key.data, key.length, message.buffer + message.pos);
  std::fill_n(end, padded - key.length, rtps::octet{0});
  message.pos += padded;
  message.length += padded;
  header[1] |= kKeyFlag;
  const auto size = static_cast<std::uint16_t>(message.pos - body);
  std::memcpy(header + 2, &size, sizeof size);
  return true;
}

}  // namespace

SentKey::SentKey(std::string_view path) : bytes_{0, 1, 0, 0} {  // the encapsulation: CDR, little endian
  const std::size_t size = path.size() + 1;
  for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<char>(size >> 8 * i & 0xff));
  bytes_.insert(bytes_.end(), path.begin(), path.end());
  bytes_.resize(std::max(kShortest, bytes_.size() + 1));
  sent = &bytes_;
}
SentKey::~SentKey() { sent = nullptr; }

NotifyWriter notify_writer asm(NOTIFY_WRITER);

// Also stores the key in a disposal or unregistration. So if the message is lost, it is sent again with the
// key. The buffer is large enough, because Fast DDS allocates it for the whole sample, which contains the
// key.
void notify_writer(void* history, rtps::CacheChange_t* change,
                   const std::chrono::steady_clock::time_point& limit) {
  if (sent != nullptr && change->kind != rtps::ALIVE) {
    TAKT_CHECK(sent->size() <= change->serializedPayload.max_size);
    std::memcpy(change->serializedPayload.data, sent->data(), sent->size());
    change->serializedPayload.length = static_cast<std::uint32_t>(sent->size());
  }
  original_notify()(history, change, limit);
}

#if TAKT_FASTDDS == 2

using AddData = bool(rtps::CDRMessage_t* message, const rtps::CacheChange_t* change, rtps::TopicKind_t topic,
                     const rtps::EntityId_t& reader, bool expects_qos, void* qos, bool* is_big);
AddData add_data asm(ADD_DATA "Pb");

bool add_data(rtps::CDRMessage_t* message, const rtps::CacheChange_t* change, rtps::TopicKind_t topic,
              const rtps::EntityId_t& reader, bool expects_qos, void* qos, bool* is_big) {
  static AddData* const original = replaced<AddData>(ADD_DATA "Pb");
  return add_with_key(*message, *change, topic,
                      [&] { return original(message, change, topic, reader, expects_qos, qos, is_big); });
}

#else

using AddData = bool(rtps::CDRMessage_t* message, const rtps::CacheChange_t* change, rtps::TopicKind_t topic,
                     const rtps::EntityId_t& reader, bool expects_qos, void* qos, bool& is_big, bool copies,
                     rtps::NetworkBuffer& payload, std::uint8_t& padding);
AddData add_data asm(ADD_DATA "RbbRNS1_13NetworkBufferERh");

bool add_data(rtps::CDRMessage_t* message, const rtps::CacheChange_t* change, rtps::TopicKind_t topic,
              const rtps::EntityId_t& reader, bool expects_qos, void* qos, bool& is_big, bool copies,
              rtps::NetworkBuffer& payload, std::uint8_t& padding) {
  static AddData* const original = replaced<AddData>(ADD_DATA "RbbRNS1_13NetworkBufferERh");
  return add_with_key(*message, *change, topic, [&] {
    return original(message, change, topic, reader, expects_qos, qos, is_big, copies, payload, padding);
  });
}

#endif

}  // namespace takt::dds
