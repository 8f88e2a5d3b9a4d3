#include "soon_repeated.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include <fastdds/rtps/common/EntityId_t.hpp>
#include <fastdds/rtps/interfaces/IReaderDataFilter.hpp>
#if TAKT_FASTDDS == 2
#include <fastdds/rtps/attributes/WriterAttributes.h>
#include <fastdds/rtps/common/CacheChange.h>
#include <fastdds/rtps/common/SequenceNumber.h>
#include <fastdds/rtps/messages/RTPSMessageSenderInterface.hpp>
#else
#include <fastdds/rtps/attributes/WriterAttributes.hpp>
#include <fastdds/rtps/common/CacheChange.hpp>
#include <fastdds/rtps/common/SequenceNumber.hpp>
#endif

#include <takt/os/clock.hpp>
#include "heartbeat_pace.hpp"
#include "message_group.hpp"
#include "replaced_function.hpp"
#include "resends.hpp"

#if TAKT_FASTDDS == 2
#define CREATE_WRITER                                                                    \
  TAKT_RTPS                                                                              \
  "19RTPSParticipantImpl12createWriterEPPNS1_10RTPSWriterERNS1_16WriterAttributesERKSt1" \
  "0shared_ptrINS1_12IPayloadPoolEEPNS1_13WriterHistoryEPNS1_14WriterListenerERKNS1_10EntityId_tEb"
#define GAPS TAKT_RTPS "14StatefulWriter30add_gaps_for_holes_in_history_ERNS1_16RTPSMessageGroupE"
#define INTERVAL TAKT_RTPS "10TimedEvent19getIntervalMilliSecEv"
#else
#define CREATE_WRITER                                                                                    \
  TAKT_RTPS                                                                                              \
  "19RTPSParticipantImpl12createWriterEPPNS1_10RTPSWriterERNS1_16WriterAttributesEPNS1_13WriterHistoryE" \
  "PNS1_14WriterListenerERKNS1_10EntityId_tEb"
#define GAPS TAKT_RTPS "14StatefulWriter29add_gaps_for_holes_in_historyERNS1_16RTPSMessageGroupE"
#define BEGIN_SUBMESSAGE TAKT_RTPS "16RTPSMessageGroup21check_and_maybe_flushERKNS1_12GuidPrefix_tE"
#endif
#define ACKNOWLEDGE                                                                              \
  TAKT_RTPS                                                                                      \
  "14StatefulReader12send_acknackEPKNS1_11WriterProxyERKNS0_11BitmapRangeINS1_16SequenceNumber_" \
  "tENS1_18SequenceNumberDiffELj256EEEPNS1_26RTPSMessageSenderInterfaceEb"
#define HEARTBEAT TAKT_RTPS "16RTPSMessageGroup13add_heartbeatERKNS1_16SequenceNumber_tES5_jbb"
#define HEARTBEATS TAKT_RTPS "14StatefulWriter29send_heartbeat_to_all_readersEv"
#define HEARTBEAT_TO TAKT_RTPS "14StatefulWriter21send_heartbeat_to_ntsERNS1_11ReaderProxyEbb"
#define LOOK_UP TAKT_RTPS "14StatefulWriter21matched_reader_lookupERNS1_6GUID_tEPPNS1_11ReaderProxyE"
#define MISSES TAKT_RTPS_CONST "11ReaderProxy18has_unacknowledgedERKNS1_16SequenceNumber_tE"

namespace takt::dds {

namespace {

using std::chrono::milliseconds;

// The discovery of a participant takes three messages there and back, each of which can be lost.
constexpr milliseconds kDiscoveryHeartbeat{20};
constexpr milliseconds kDiscoveryNackDelay{10};
// Ignore requests for a message that may still be on its way.
constexpr milliseconds kDiscoveryNackSuppression{50};
/// The shortest period of heartbeats of all writers.
constexpr Nanoseconds kHeartbeat = milliseconds{10};

/// Fast DDS sends an authentication message to all participants, and each drops those for others. With this
/// filter, only the receiver gets it, so fragments of different messages never meet (reader_checks.cpp).
class ToReceiver final : public eprosima::fastdds::rtps::IReaderDataFilter {
 public:
  [[nodiscard]] bool is_relevant(const rtps::CacheChange_t& message,
                                 const rtps::GUID_t& reader) const override {
    // Before the receiver stand the encapsulation and the identities of two messages.
    constexpr std::size_t kReceiver = 4 + 24 + 24;
    const rtps::SerializedPayload_t& content = message.serializedPayload;
    return content.length >= kReceiver + rtps::GuidPrefix_t::size &&
           std::equal(reader.guidPrefix.value, reader.guidPrefix.value + rtps::GuidPrefix_t::size,
                      content.data + kReceiver);
  }
};
ToReceiver to_receiver;

// Readers that have ended leave their pace behind. If there are so many, all are learned again.
constexpr std::size_t kMostPaces = 4096;

std::mutex paces_mutex;
std::map<std::pair<rtps::GUID_t, rtps::GUID_t>, HeartbeatPace> paces;  // by writer and reader
std::map<rtps::GuidPrefix_t, Nanoseconds> round_trips;                 // by the participant of the readers
std::map<const void*, FirstRequestPace> first_requests;  // by what the reader knows of the writer

bool is_due(const rtps::GUID_t& writer, const rtps::GUID_t& reader, std::uint64_t newest) {
  const std::lock_guard lock{paces_mutex};
  if (paces.size() >= kMostPaces) paces.clear();
  const auto known = round_trips.find(reader.guidPrefix);
  const auto pace =
      paces.try_emplace({writer, reader}, known == round_trips.end() ? Nanoseconds{0} : known->second);
  return pace.first->second.is_due(os::now(), kHeartbeat, newest);
}

bool is_due(const void* writer) {
  const std::lock_guard lock{paces_mutex};
  if (first_requests.size() >= kMostPaces) first_requests.clear();
  return first_requests[writer].is_due(os::now());
}

/// The heartbeats of a writer that this thread sends: first it learns the readers of the writer, then it
/// sends a heartbeat to each one that is to get one.
struct Round {
  explicit Round(const void* of) : writer(guid_of(of)) { current = this; }
  Round(const Round&) = delete;
  Round& operator=(const Round&) = delete;
  ~Round() { current = nullptr; }
  [[nodiscard]] bool is_due_to_reader() const {
    return !is_answer_paused(writer, *reader, kHeartbeat / 2) && is_due(writer, *reader, newest);
  }

  const rtps::GUID_t writer;
  std::vector<rtps::GUID_t> readers;
  std::uint64_t newest = 0;              // the number of the writer's newest sample
  const rtps::GUID_t* reader = nullptr;  // null while it learns the readers
  static thread_local Round* current;
};
thread_local Round* Round::current = nullptr;

#if TAKT_FASTDDS == 2
using CreateWriter = bool(void* participant, rtps::RTPSWriter** made, rtps::WriterAttributes& attributes,
                          const void* pool, void* history, void* listener, const rtps::EntityId_t& id,
                          bool is_builtin);
#else
using CreateWriter = bool(void* participant, rtps::RTPSWriter** made, rtps::WriterAttributes& attributes,
                          void* history, void* listener, const rtps::EntityId_t& id, bool is_builtin);
using BeginSubmessage = void(void* group, const rtps::GuidPrefix_t& receiver);
using SendMessage = void(void* group);
#endif
using Acknowledge = void(void* reader, const void* writer, const rtps::SequenceNumberSet_t& requested,
                         void* sender, bool is_final);
using AddHeartbeat = bool(void* group, const rtps::SequenceNumber_t& oldest,
                          const rtps::SequenceNumber_t& newest, std::uint32_t count, bool is_final,
                          bool liveliness);
using AddGaps = void(void* writer, void* group);
using SendHeartbeats = void(void* writer);
using SendHeartbeat = void(void* writer, void* reader, bool liveliness, bool force);
using LookUp = bool(void* writer, rtps::GUID_t& reader, void** found);
using Misses = bool(const void* reader, const rtps::SequenceNumber_t& oldest);

/// The replaced functions of Fast DDS, and those that are called.
struct Originals {
  CreateWriter* create_writer = replaced<CreateWriter>(CREATE_WRITER);
#if TAKT_FASTDDS != 2
  BeginSubmessage* begin_submessage = replaced<BeginSubmessage>(BEGIN_SUBMESSAGE);
  SendMessage* send_message = replaced<SendMessage>(TAKT_RTPS "16RTPSMessageGroup15flush_and_resetEv");
#endif
  Acknowledge* acknowledge = replaced<Acknowledge>(ACKNOWLEDGE);
  AddHeartbeat* add_heartbeat = replaced<AddHeartbeat>(HEARTBEAT);
  AddGaps* add_gaps = replaced<AddGaps>(GAPS);
  SendHeartbeats* send_heartbeats = replaced<SendHeartbeats>(HEARTBEATS);
  SendHeartbeat* send_heartbeat = replaced<SendHeartbeat>(HEARTBEAT_TO);
  LookUp* look_up = replaced<LookUp>(LOOK_UP);
  Misses* misses = replaced<Misses>(MISSES);
};
const Originals& originals() noexcept {
  static const Originals found;
  return found;
}

void set_times(rtps::WriterAttributes& attributes) {
#if TAKT_FASTDDS == 2
  attributes.times.heartbeatPeriod = duration(kDiscoveryHeartbeat);
  attributes.times.nackResponseDelay = duration(kDiscoveryNackDelay);
  attributes.times.nackSupressionDuration = duration(kDiscoveryNackSuppression);
#else
  attributes.times.heartbeat_period = duration(kDiscoveryHeartbeat);
  attributes.times.nack_response_delay = duration(kDiscoveryNackDelay);
  attributes.times.nack_supression_duration = duration(kDiscoveryNackSuppression);
#endif
}

}  // namespace

void repeat_lost_messages_soon() noexcept { static_cast<void>(originals()); }

void heartbeat_answered(const rtps::GUID_t& writer, const rtps::GUID_t& reader) {
  const std::lock_guard lock{paces_mutex};
  const auto found = paces.find({writer, reader});
  if (found == paces.end()) return;
  found->second.answered(os::now());
  if (round_trips.size() >= kMostPaces) round_trips.clear();
  round_trips[reader.guidPrefix] = found->second.round_trip();
}

Nanoseconds round_trip_to(const rtps::GuidPrefix_t& participant) {
  const std::lock_guard lock{paces_mutex};
  const auto found = round_trips.find(participant);
  return found == round_trips.end() ? Nanoseconds{0} : found->second;
}

CreateWriter create_writer asm(CREATE_WRITER);
#if TAKT_FASTDDS == 2
bool create_writer(void* participant, rtps::RTPSWriter** made, rtps::WriterAttributes& attributes,
                   const void* pool, void* history, void* listener, const rtps::EntityId_t& id,
                   bool is_builtin) {
  if (is_builtin) set_times(attributes);
  if (!originals().create_writer(participant, made, attributes, pool, history, listener, id, is_builtin))
    return false;
#else
bool create_writer(void* participant, rtps::RTPSWriter** made, rtps::WriterAttributes& attributes,
                   void* history, void* listener, const rtps::EntityId_t& id, bool is_builtin) {
  if (is_builtin) set_times(attributes);
  if (!originals().create_writer(participant, made, attributes, history, listener, id, is_builtin))
    return false;
#endif
  if (id == rtps::participant_stateless_message_writer_entity_id) (*made)->reader_data_filter(&to_receiver);
  return true;
}

// Called for each heartbeat period while a reader has not acknowledged every sample. Fast DDS would send one
// heartbeat to all readers.
SendHeartbeats send_heartbeats asm(HEARTBEATS);
void send_heartbeats(void* writer) {
  Round round{writer};
  originals().send_heartbeats(writer);
  for (rtps::GUID_t& reader : round.readers) {
    void* found = nullptr;
    if (!originals().look_up(writer, reader, &found)) continue;
    round.reader = &reader;
    originals().send_heartbeat(writer, found, false, false);
  }
}

AddHeartbeat add_heartbeat asm(HEARTBEAT);
bool add_heartbeat(void* group, const rtps::SequenceNumber_t& oldest, const rtps::SequenceNumber_t& newest,
                   std::uint32_t count, bool is_final, bool liveliness) {
  Round* const round = Round::current;
  if (round == nullptr || round->reader != nullptr)
    return originals().add_heartbeat(group, oldest, newest, count, is_final, liveliness);
  round->readers = message_group(group).receivers->remote_guids();
  round->newest = newest.to64long();
  return true;
}

AddGaps add_gaps asm(GAPS);
void add_gaps(void* writer, void* group) {
  if (Round::current == nullptr || Round::current->reader != nullptr) originals().add_gaps(writer, group);
}

// Decides whether a reader gets a heartbeat.
Misses misses asm(MISSES);
bool misses(const void* reader, const rtps::SequenceNumber_t& oldest) {
  return originals().misses(reader, oldest) &&
         (Round::current == nullptr || Round::current->reader == nullptr ||
          Round::current->is_due_to_reader());
}

// The request for a first heartbeat asks for no sample, from number 0 on.
Acknowledge acknowledge asm(ACKNOWLEDGE);
void acknowledge(void* reader, const void* writer, const rtps::SequenceNumberSet_t& requested, void* sender,
                 bool is_final) {
  if (requested.empty() && requested.base() == rtps::SequenceNumber_t{} && !is_due(writer)) return;
  originals().acknowledge(reader, writer, requested, sender, is_final);
}

#if TAKT_FASTDDS == 2
// Called only for the timer that repeats a message of an authentication, after twice this time in ms. Such a
// message has up to 5 kB and costs its receiver up to some milliseconds. Fast DDS 3 has properties for this.
double half_of_authentication_period(const void* timer) asm(INTERVAL);
double half_of_authentication_period(const void*) { return 100; }
#else
// Called before Fast DDS composes a submessage. If several messages in a row are for one receiver, version 3
// names it only in the first one, and another participant that has got its port would join the fragments in
// the others with those of its own message. So each fragment of an authentication message begins a message.
BeginSubmessage begin_submessage asm(BEGIN_SUBMESSAGE);
void begin_submessage(void* group, const rtps::GuidPrefix_t& receiver) {
  if (message_group(group).from->getGuid().entityId == rtps::participant_stateless_message_writer_entity_id)
    originals().send_message(group);
  originals().begin_submessage(group, receiver);
}
#endif

}  // namespace takt::dds
