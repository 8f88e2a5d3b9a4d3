// The Fast DDS objects behind a Participant, shared by the sources of this room. Not for other rooms.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <typeindex>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include "workarounds/filtered_transport.hpp"
#include <takt/wire/notices.hpp>
#include <takt/dds/participant.hpp>

namespace takt::dds {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;

/// An object whose readers and writers can be recreated. This is needed when addresses change, because in
/// this version of Fast DDS readers and writers announce their addresses only when they are created.
class Recreatable {
 public:
  virtual ~Recreatable() = default;
  /// Recreates the readers and writers. Called on the thread that rescans the interfaces, while other threads
  /// use this object.
  virtual void recreate() = 0;
};

class Watch;

/// The one participant of the process, with its topics. Thread-safe.
class OwnParticipant final : public Participant {
 public:
  /// `watch` is null without DDS Security.
  OwnParticipant(fast::DomainParticipant* participant, fast::Publisher* publisher,
                 fast::Subscriber* subscriber, bool only_loopback, std::unique_ptr<wire::Notices> notices,
                 std::unique_ptr<Watch> watch, std::shared_ptr<PacketFilter> filter);
  ~OwnParticipant() override;
  void rescan_interfaces() override;
  [[nodiscard]] const std::optional<security::Identity>& identity() const noexcept override {
    return identity_;
  }
  [[nodiscard]] std::uint64_t refused() const noexcept override {
    return filter_->refused.load(std::memory_order_relaxed);
  }

  /// Reports rejected participants and packets.
  [[nodiscard]] wire::Notices& notices() noexcept { return *notices_; }
  /// Observes the other participants; null without DDS Security.
  [[nodiscard]] Watch* watch() noexcept { return watch_.get(); }

  /// Returns the topic of this name, and creates it if needed. Fails if the topic has another type in this
  /// process, or if a different type has the same name.
  Result<fast::Topic*> topic(const std::string& name, const fast::TypeSupport& type);
  /// Releases a topic that topic() returned; the last release deletes the topic.
  void release(fast::Topic* topic);

  void enlist(Recreatable& one);
  /// On return, `one` is not being recreated and will never be.
  void dismiss(Recreatable& one);

  [[nodiscard]] fast::DomainParticipant& participant() noexcept { return *participant_; }
  [[nodiscard]] fast::Publisher& publisher() noexcept { return *publisher_; }
  /// Deletes a writer, which may be null. Removes its samples first. Otherwise Fast DDS frees the samples
  /// while the writer's heartbeat still runs, and the heartbeat loops for ever in search of a freed sample.
  void end(fast::DataWriter*& writer);
  /// Creates a reader; returns null if DDS created none. Readers are created and deleted only while no packet
  /// is handled, see ReceiveLock. The caller must hold no lock that a listener waits for.
  fast::DataReader* make_reader(fast::Topic* topic, const fast::DataReaderQos& qos,
                                fast::DataReaderListener* listener, const fast::StatusMask& mask);
  /// Deletes a reader, which may be null.
  void end(fast::DataReader*& reader);

 private:
  struct Shared {
    fast::Topic* topic = nullptr;
    int users = 0;
  };
  struct Known {
    // All users of the type must agree on its largest sample size and on its decoder.
    std::uint32_t size = 0;
    std::type_index decoder{typeid(void)};
    int topics = 0;
  };
  std::unique_ptr<wire::Notices> notices_;
  std::unique_ptr<Watch> watch_;  // the listener of the participant
  std::shared_ptr<PacketFilter> filter_;
  std::optional<security::Identity> identity_;
  fast::DomainParticipant* participant_;
  fast::Publisher* publisher_;
  fast::Subscriber* subscriber_;
  std::mutex mutex_;
  std::map<std::string, Shared> topics_;
  std::map<std::string, Known> types_;
  std::mutex remaking_;
  std::vector<Recreatable*> remade_;
  bool only_loopback_;  // whether there was only loopback when the readers and writers were created
};

/// Casts a Participant, which is always an OwnParticipant.
OwnParticipant& own(Participant& participant);

eprosima::fastrtps::Duration_t duration(Nanoseconds time);

/// A number for the GUID of a writer or reader, for comparisons.
std::uint64_t number_of(const rtps::GUID_t& guid);
std::uint64_t number_of(const rtps::InstanceHandle_t& handle);
/// A number for the GUID prefix of a participant, for comparisons.
std::uint64_t number_of(const rtps::GuidPrefix_t& prefix);

/// The name of the QoS policy with this number, such as "reliability".
std::string policy_name(fast::QosPolicyId_t id);

}  // namespace takt::dds
