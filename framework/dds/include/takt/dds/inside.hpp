// What the sources of this room share: Fast DDS's objects behind a Participant. Not for other rooms.
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
#include <takt/dds/filtered_transport.hpp>
#include <takt/dds/notices.hpp>
#include <takt/dds/participant.hpp>

namespace takt::dds {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;

/// A reader or writer, or both, which can be made again: those of this version of Fast DDS say once and for
/// all by which addresses they are reached.
class Recreatable {
 public:
  virtual ~Recreatable() = default;
  /// On the thread that rescans the interfaces, while others use it.
  virtual void recreate() = 0;
};

class Watch;

/// The one participant of the process, with its topics. Thread-safe.
class OwnParticipant final : public Participant {
 public:
  /// `watch`: none without DDS Security.
  OwnParticipant(fast::DomainParticipant* participant, fast::Publisher* publisher,
                 fast::Subscriber* subscriber, bool only_loopback, std::unique_ptr<Notices> notices,
                 std::unique_ptr<Watch> watch, std::shared_ptr<PacketFilter> filter);
  ~OwnParticipant() override;
  void rescan_interfaces() override;
  [[nodiscard]] const std::optional<security::Identity>& identity() const noexcept override {
    return identity_;
  }
  [[nodiscard]] std::uint64_t refused() const noexcept override {
    return filter_->refused.load(std::memory_order_relaxed);
  }

  /// Whom this process refuses.
  [[nodiscard]] Notices& notices() noexcept { return *notices_; }
  /// None without DDS Security.
  [[nodiscard]] Watch* watch() noexcept { return watch_.get(); }

  /// The topic of this name, made if there is none yet. Fails where it has another type here, or its type is
  /// another one of the same name.
  Result<fast::Topic*> topic(const std::string& name, const fast::TypeSupport& type);
  /// Lets go of what topic() gave; it is deleted with its last user.
  void release(fast::Topic* topic);

  void enlist(Recreatable& one);
  /// On return it is not being made again and will not be.
  void dismiss(Recreatable& one);

  [[nodiscard]] fast::DomainParticipant& participant() noexcept { return *participant_; }
  [[nodiscard]] fast::Publisher& publisher() noexcept { return *publisher_; }
  /// Ends a writer, which may be null. Its samples go first: Fast DDS takes the room of each before it stops
  /// the heartbeat, which in between counts from a sample to one that has no number any more, for ever.
  void end(fast::DataWriter*& writer);
  /// Null where DDS made none. Neither while a packet is handled, see ReceiveLock; the caller holds no lock
  /// that a listener waits for.
  fast::DataReader* make_reader(fast::Topic* topic, const fast::DataReaderQos& qos,
                                fast::DataReaderListener* listener, const fast::StatusMask& mask);
  /// Ends a reader, which may be null.
  void end(fast::DataReader*& reader);

 private:
  struct Shared {
    fast::Topic* topic = nullptr;
    int users = 0;
  };
  struct Known {
    // All that use the type must agree on the size of its largest sample and on who decodes it.
    std::uint32_t size = 0;
    std::type_index decoder{typeid(void)};
    int topics = 0;
  };
  std::unique_ptr<Notices> notices_;
  std::unique_ptr<Watch> watch_;  // listens to the participant
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
  bool only_loopback_;  // when what there is was made
};

/// Every Participant is one of ours.
OwnParticipant& own(Participant& participant);

eprosima::fastrtps::Duration_t duration(Nanoseconds time);

/// Numbers a writer's or reader's identity, for whoever must compare it.
std::uint64_t number_of(const rtps::GUID_t& guid);
std::uint64_t number_of(const rtps::InstanceHandle_t& handle);
/// The same for all that belong to one participant.
std::uint64_t number_of(const rtps::GuidPrefix_t& prefix);

/// The name of a QoS policy by its number: "reliability".
std::string policy_name(fast::QosPolicyId_t id);

}  // namespace takt::dds
