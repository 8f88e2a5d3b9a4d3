#include "soon_repeated.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include <fastdds/rtps/attributes/WriterAttributes.h>
#include <fastdds/rtps/common/CacheChange.h>
#include <fastdds/rtps/common/SequenceNumber.h>
#include <fastdds/rtps/reader/StatefulReader.h>
#include <fastdds/rtps/resources/TimedEvent.h>
#include <fastdds/rtps/writer/ReaderProxy.h>
#include <fastdds/rtps/writer/StatefulWriter.h>
#include <fastdds/rtps/common/EntityId_t.hpp>
#include <fastdds/rtps/interfaces/IReaderDataFilter.hpp>

#include <takt/os/clock.hpp>
#include "heartbeat_pace.hpp"
#include "replaced_function.hpp"
#include "resends.hpp"

namespace eprosima::fastrtps::rtps {

class IPayloadPool;

// Fast DDS does not install the header of this class; this declaration lists only the replaced function.
class RTPSParticipantImpl {
 public:
  bool createWriter(RTPSWriter** made, WriterAttributes& attributes,
                    const std::shared_ptr<IPayloadPool>& pool, WriterHistory* history,
                    WriterListener* listener, const EntityId_t& id, bool is_builtin);
};

}  // namespace eprosima::fastrtps::rtps

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using CreateWriter = bool(rtps::RTPSParticipantImpl*, rtps::RTPSWriter**, rtps::WriterAttributes&,
                          const std::shared_ptr<rtps::IPayloadPool>&, rtps::WriterHistory*,
                          rtps::WriterListener*, const rtps::EntityId_t&, bool);
using SendHeartbeats = void(rtps::StatefulWriter*);
using Acknowledge = void(rtps::StatefulReader*, const rtps::WriterProxy*, const rtps::SequenceNumberSet_t&,
                         rtps::RTPSMessageSenderInterface*, bool);
using Interval = double(rtps::TimedEvent*);

CreateWriter* original() noexcept {
  static CreateWriter* const found = takt::dds::replaced<CreateWriter>(
      "_ZN8eprosima8fastrtps4rtps19RTPSParticipantImpl12createWriterEPPNS1_10RTPSWriterERNS1_"
      "16WriterAttributesERKSt10shared_ptrINS1_12IPayloadPoolEEPNS1_13WriterHistoryEPNS1_"
      "14WriterListenerERKNS1_10EntityId_tEb");
  return found;
}

Acknowledge* acknowledge() noexcept {
  static Acknowledge* const found = takt::dds::replaced<Acknowledge>(
      "_ZN8eprosima8fastrtps4rtps14StatefulReader12send_acknackEPKNS1_11WriterProxyERKNS0_11BitmapRangeINS1_"
      "16SequenceNumber_tENS1_18SequenceNumberDiffELj256EEEPNS1_26RTPSMessageSenderInterfaceEb");
  return found;
}

constexpr std::uint32_t kMs = 1'000'000;
// The discovery of a participant takes three messages there and back, each of which can be lost.
const eprosima::fastrtps::Duration_t kDiscoveryHeartbeat{0, 20 * kMs};
const eprosima::fastrtps::Duration_t kDiscoveryNackDelay{0, 10 * kMs};
// Ignore requests for a message that may still be on its way.
const eprosima::fastrtps::Duration_t kDiscoveryNackSuppression{0, 50 * kMs};
// Fast DDS repeats a message of an authentication after twice this time. Such a message has up to 3 kB and
// costs its receiver up to some milliseconds.
constexpr double kHalfAuthenticationMs = 100;

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
std::map<std::pair<rtps::GUID_t, rtps::GUID_t>, takt::dds::HeartbeatPace> paces;  // by writer and reader
std::map<rtps::GuidPrefix_t, takt::Nanoseconds> round_trips;  // by the participant of the readers
std::map<const rtps::WriterProxy*, takt::dds::FirstRequestPace> first_requests;

bool is_due(const rtps::GUID_t& writer, const rtps::GUID_t& reader, takt::Nanoseconds period,
            std::uint64_t newest) {
  const std::lock_guard lock{paces_mutex};
  if (paces.size() >= kMostPaces) paces.clear();
  const auto known = round_trips.find(reader.guidPrefix);
  const auto pace =
      paces.try_emplace({writer, reader}, known == round_trips.end() ? takt::Nanoseconds{0} : known->second);
  return pace.first->second.is_due(takt::os::now(), period, newest);
}

bool is_due(const rtps::WriterProxy* writer) {
  const std::lock_guard lock{paces_mutex};
  if (first_requests.size() >= kMostPaces) first_requests.clear();
  return first_requests[writer].is_due(takt::os::now());
}

}  // namespace

namespace takt::dds {

void repeat_lost_messages_soon() noexcept {
  static_cast<void>(original());
  static_cast<void>(acknowledge());
  static_cast<void>(replaced<SendHeartbeats>(
      "_ZN8eprosima8fastrtps4rtps14StatefulWriter29send_heartbeat_to_all_readersEv"));
  static_cast<void>(replaced<Interval>("_ZN8eprosima8fastrtps4rtps10TimedEvent19getIntervalMilliSecEv"));
}

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

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

bool RTPSParticipantImpl::createWriter(RTPSWriter** made, WriterAttributes& attributes,
                                       const std::shared_ptr<IPayloadPool>& pool, WriterHistory* history,
                                       WriterListener* listener, const EntityId_t& id, bool is_builtin) {
  if (is_builtin) {
    attributes.times.heartbeatPeriod = kDiscoveryHeartbeat;
    attributes.times.nackResponseDelay = kDiscoveryNackDelay;
    attributes.times.nackSupressionDuration = kDiscoveryNackSuppression;
  }
  if (!original()(this, made, attributes, pool, history, listener, id, is_builtin)) return false;
  if (id == participant_stateless_message_writer_entity_id) (*made)->reader_data_filter(&to_receiver);
  return true;
}

// Called for each heartbeat period while a reader has not acknowledged every sample. No reader of Takt is in
// the same process as the writer or shares memory with it.
void StatefulWriter::send_heartbeat_to_all_readers() {
  const SequenceNumber_t oldest = get_seq_num_min();
  const SequenceNumber_t next = next_sequence_number();
  const takt::Nanoseconds period{m_times.heartbeatPeriod.to_ns()};
  for (ReaderProxy* reader : matched_remote_readers_) {
    if (reader->is_reliable() &&
        reader->has_unacknowledged(oldest == SequenceNumber_t::unknown() ? next - 1 : oldest) &&
        !takt::dds::is_answer_paused(m_guid, reader->guid(), period / 2) &&
        is_due(m_guid, reader->guid(), period, next.to64long()))
      send_heartbeat_to_nts(*reader);
  }
}

// The request for a first heartbeat asks for no sample, from number 0 on.
void StatefulReader::send_acknack(const WriterProxy* writer, const SequenceNumberSet_t& requested,
                                  RTPSMessageSenderInterface* sender, bool is_final) {
  if (requested.empty() && requested.base() == SequenceNumber_t{} && !is_due(writer)) return;
  acknowledge()(this, writer, requested, sender, is_final);
}

// Called only for the timer that repeats a message of an authentication.
double TimedEvent::getIntervalMilliSec() { return kHalfAuthenticationMs; }

}  // namespace eprosima::fastrtps::rtps
