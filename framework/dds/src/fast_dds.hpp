// The headers of Fast DDS that several files of this room include, and one form of what versions 2 and 3 of
// Fast DDS declare differently. Only the source files of this room include this header.
//
// TAKT_FASTDDS is the major version of Fast DDS, from cmake/TaktWire.cmake.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#if TAKT_FASTDDS == 2
#include <fastdds/rtps/attributes/RTPSParticipantAttributes.h>
#include <fastdds/rtps/common/Time_t.h>
#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/TransportInterface.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#else
#include <fastdds/LibrarySettings.hpp>
#include <fastdds/dds/builtin/topic/ParticipantBuiltinTopicData.hpp>
#include <fastdds/rtps/attributes/RTPSParticipantAttributes.hpp>
#include <fastdds/rtps/common/Time_t.hpp>
#include <fastdds/rtps/common/WriteParams.hpp>
#include <fastdds/rtps/transport/SenderResource.hpp>
#include <fastdds/rtps/transport/TransportInterface.hpp>
#include <fastdds/rtps/transport/TransportReceiverInterface.hpp>
#include <fastdds/utils/IPLocator.hpp>
#endif

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/common/LocatorSelector.hpp>

#include <takt/core/time.hpp>
#include <takt/wire/rtps.hpp>

namespace takt::dds {

namespace fast = eprosima::fastdds::dds;
namespace transport = eprosima::fastdds::rtps;
#if TAKT_FASTDDS == 2
namespace rtps = eprosima::fastrtps::rtps;
using Duration = eprosima::fastrtps::Duration_t;
inline constexpr auto kOk = eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
#else
namespace rtps = eprosima::fastdds::rtps;
using Duration = fast::Duration_t;
inline constexpr fast::ReturnCode_t kOk = fast::RETCODE_OK;
#endif

inline Duration duration(Nanoseconds time) {
  const auto ns = time.count();
  return {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)};
}

// ---- Participants

/// Participants of this process exchange samples as those of different processes do.
inline void turn_off_intraprocess_delivery() {
#if TAKT_FASTDDS == 2
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
#else
  eprosima::fastdds::LibrarySettings settings;
  settings.intraprocess_delivery = eprosima::fastdds::INTRAPROCESS_OFF;
  fast::DomainParticipantFactory::get_instance()->set_library_settings(settings);
#endif
}

inline wire::ParticipantNumber number_in(const rtps::GuidPrefix_t& prefix) {
  wire::ParticipantNumber number{};
  std::copy_n(prefix.value, number.size(), number.begin());
  return number;
}

/// Makes a participant a client of the discovery server with this GUID prefix at this locator.
inline void use_server(rtps::DiscoverySettings& settings, [[maybe_unused]] const rtps::GuidPrefix_t& prefix,
                       const rtps::Locator_t& locator) {
  settings.discoveryProtocol = rtps::DiscoveryProtocol::CLIENT;
#if TAKT_FASTDDS == 2
  rtps::RemoteServerAttributes server;
  server.guidPrefix = prefix;
  server.metatrafficUnicastLocatorList.push_back(locator);
  settings.m_DiscoveryServers.push_back(server);
#else
  settings.m_DiscoveryServers.push_back(locator);
#endif
}

/// Listens to what happens to other participants.
class ParticipantListener : public fast::DomainParticipantListener {
 private:
  /// The participant was found, or has changed. With DDS Security, version 3 waits for the authentication.
  virtual void found(const rtps::GuidPrefix_t& participant, const std::string& name) = 0;
  /// The participant has left, or was not heard for its lease.
  virtual void lost(const rtps::GuidPrefix_t& participant) = 0;
  /// The authentication of the participant has ended.
  virtual void authenticated(const rtps::GuidPrefix_t& participant, bool accepted) = 0;

#if TAKT_FASTDDS == 2
  void on_participant_discovery(fast::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& info) final {
    using Info = rtps::ParticipantDiscoveryInfo;
    const rtps::ParticipantProxyData& data = info.info;
    if (info.status == Info::REMOVED_PARTICIPANT || info.status == Info::DROPPED_PARTICIPANT)
      lost(data.m_guid.guidPrefix);
    else
      found(data.m_guid.guidPrefix, data.m_participantName.to_string());
  }
#else
  void on_participant_discovery(fast::DomainParticipant*, rtps::ParticipantDiscoveryStatus status,
                                const fast::ParticipantBuiltinTopicData& data, bool&) final {
    using Status = rtps::ParticipantDiscoveryStatus;
    if (status == Status::REMOVED_PARTICIPANT || status == Status::DROPPED_PARTICIPANT)
      lost(data.guid.guidPrefix);
    else if (status != Status::IGNORED_PARTICIPANT)
      found(data.guid.guidPrefix, data.participant_name.to_string());
  }
#endif
  void onParticipantAuthentication(fast::DomainParticipant*,
                                   rtps::ParticipantAuthenticationInfo&& info) final {
    authenticated(info.guid.guidPrefix,
                  info.status != rtps::ParticipantAuthenticationInfo::UNAUTHORIZED_PARTICIPANT);
  }
};

// ---- Types

/// Returns the size of the largest sample of a type, including the encapsulation header.
inline std::uint32_t max_size_of(const fast::TopicDataType& type) {
#if TAKT_FASTDDS == 2
  return type.m_typeSize;
#else
  return type.max_serialized_type_size;
#endif
}

/// Encodes a sample, with its encapsulation header, into `to`. Returns false if it does not fit.
inline bool encode_sample(fast::TopicDataType& type, const void* sample, rtps::SerializedPayload_t& to) {
#if TAKT_FASTDDS == 2
  return type.serialize(const_cast<void*>(sample), &to);
#else
  return type.serialize(sample, to, fast::XCDR_DATA_REPRESENTATION);
#endif
}

/// Returns the key of a sample. The type must have a key.
inline rtps::InstanceHandle_t key_of_sample(fast::TopicDataType& type, const void* sample) {
  rtps::InstanceHandle_t key;
#if TAKT_FASTDDS == 2
  type.getKey(const_cast<void*>(sample), &key);
#else
  type.compute_key(sample, key);
#endif
  return key;
}

/// A type of samples that are encoded already, and that have no description.
class EncodedType : public fast::TopicDataType {
 public:
  EncodedType(const std::string& name, std::uint32_t max_size, bool keyed) {
#if TAKT_FASTDDS == 2
    setName(name.c_str());
    m_typeSize = max_size;
    m_isGetKeyDefined = keyed;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
#else
    set_name(name);
    max_serialized_type_size = max_size;
    is_compute_key_provided = keyed;
#endif
  }
  bool is_bounded() const override { return true; }

 private:
  /// Copies the sample at `data`, which a writer was given. Returns false if it is not valid.
  virtual bool encode(const void* data, rtps::SerializedPayload_t& to) = 0;
  /// Passes a sample to the object at `data`, which a reader was given.
  virtual void decode(const rtps::SerializedPayload_t& from, void* data) = 0;
  virtual std::uint32_t size_of(const void* data) = 0;
  /// Called only for a type with a key.
  virtual rtps::InstanceHandle_t key_of(const void* data) = 0;

#if TAKT_FASTDDS == 2
  bool serialize(void* data, rtps::SerializedPayload_t* payload) final { return encode(data, *payload); }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) final {
    decode(*payload, data);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) final {
    return [this, data] { return size_of(data); };
  }
  void* createData() final { return nullptr; }
  void deleteData(void*) final {}
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool) final {
    if (m_isGetKeyDefined) *handle = key_of(data);
    return m_isGetKeyDefined;
  }
#else
  bool serialize(const void* data, rtps::SerializedPayload_t& payload, fast::DataRepresentationId_t) final {
    return encode(data, payload);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) final {
    decode(payload, data);
    return true;
  }
  std::uint32_t calculate_serialized_size(const void* data, fast::DataRepresentationId_t) final {
    return size_of(data);
  }
  void* create_data() final { return nullptr; }
  void delete_data(void*) final {}
  bool compute_key(rtps::SerializedPayload_t&, rtps::InstanceHandle_t&, bool) final { return false; }
  bool compute_key(const void* data, rtps::InstanceHandle_t& handle, bool) final {
    if (is_compute_key_provided) handle = key_of(data);
    return is_compute_key_provided;
  }
#endif
};

// ---- Samples

/// Returns false if DDS rejects the sample. Fast DDS takes a non-const pointer in version 2, but does not
/// write through it.
inline bool write_sample(fast::DataWriter& writer, const void* sample, rtps::WriteParams parameters = {}) {
#if TAKT_FASTDDS == 2
  return writer.write(const_cast<void*>(sample), parameters);
#else
  return writer.write(sample, parameters) == kOk;
#endif
}

/// Returns false if there is no further sample.
inline bool take_sample(fast::DataReader& reader, void* sample, fast::SampleInfo& info) {
  return reader.take_next_sample(sample, &info) == kOk;
}

/// Waits until all readers have acknowledged all samples. Returns false if that takes longer than `limit`.
inline bool wait_for_readers(fast::DataWriter& writer, Nanoseconds limit) {
  return writer.wait_for_acknowledgments(duration(limit)) == kOk;
}

/// Sets the period in which the writer sends heartbeats, instead of 3 s. A heartbeat asks readers to
/// acknowledge samples, and is how they notice that they miss one. The writer answers a request after 1 ms
/// instead of 5 ms.
inline void set_times(fast::DataWriterQos& qos, Nanoseconds heartbeat) {
  auto& times = qos.reliable_writer_qos().times;
  const Duration answer = duration(std::chrono::milliseconds{1});
#if TAKT_FASTDDS == 2
  times.heartbeatPeriod = duration(heartbeat);
  times.nackResponseDelay = answer;
#else
  times.heartbeat_period = duration(heartbeat);
  times.nack_response_delay = answer;
#endif
}

/// Sets after which time the reader answers a heartbeat, instead of 5 ms. It asks a new writer for samples
/// after 10 ms instead of 70 ms.
inline void set_times(fast::DataReaderQos& qos, Nanoseconds answer) {
  auto& times = qos.reliable_reader_qos().times;
  const Duration first = duration(std::chrono::milliseconds{10});
#if TAKT_FASTDDS == 2
  times.heartbeatResponseDelay = duration(answer);
  times.initialAcknackDelay = first;
#else
  times.heartbeat_response_delay = duration(answer);
  times.initial_acknack_delay = first;
#endif
}

// ---- Transports

/// Sends messages to locators.
class Sender final : public rtps::SenderResource {
 public:
  /// Returns false if the message was not sent to all locators.
  using Send = std::function<bool(std::span<const rtps::octet> message, rtps::LocatorsIterator& from,
                                  const rtps::LocatorsIterator& end)>;

  Sender(std::int32_t kind, Send send) : SenderResource(kind) {
#if TAKT_FASTDDS == 2
    send_lambda_ = [send = std::move(send)](const rtps::octet* bytes, std::uint32_t size,
                                            rtps::LocatorsIterator* from, rtps::LocatorsIterator* end,
                                            const std::chrono::steady_clock::time_point&) {
      return send({bytes, size}, *from, *end);
    };
#else
    send_buffers_lambda_ = [send = std::move(send)](const std::vector<rtps::NetworkBuffer>& buffers,
                                                    std::uint32_t size, rtps::LocatorsIterator* from,
                                                    rtps::LocatorsIterator* end,
                                                    const std::chrono::steady_clock::time_point&) {
      if (buffers.size() == 1)
        return send({static_cast<const rtps::octet*>(buffers[0].buffer), size}, *from, *end);
      thread_local std::vector<rtps::octet> whole;
      whole.clear();
      for (const rtps::NetworkBuffer& each : buffers) {
        const auto* bytes = static_cast<const rtps::octet*>(each.buffer);
        whole.insert(whole.end(), bytes, bytes + each.size);
      }
      return send(whole, *from, *end);
    };
#endif
  }
};

/// A transport without the functions that version 3 has in addition.
class Transport : public transport::TransportInterface {
 public:
  using TransportInterface::TransportInterface;

 private:
  /// Prepares the transport; returns false if that fails.
  virtual bool init() = 0;

#if TAKT_FASTDDS == 2
  bool init(const rtps::PropertyPolicy*) final { return init(); }
#else
  bool init(const rtps::PropertyPolicy*, const std::uint32_t&) final { return init(); }
  bool is_locator_reachable(const rtps::Locator_t& locator) final { return IsLocatorSupported(locator); }
#endif
};

}  // namespace takt::dds
