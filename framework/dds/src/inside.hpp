// The implementation of Participant with Fast DDS objects, for the source files of this room only.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <typeindex>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>
#include <takt/os/network.hpp>
#include <takt/os/notice.hpp>
#include <takt/wire/notices.hpp>
#include "fast_dds.hpp"
#include "udp_transport.hpp"
#include "workarounds/reader_checks.hpp"

namespace takt::dds {

class DiscoveryListener;
class KnownParticipants;

/// Where writers send the samples for a reader.
enum class Receives {
  alone,    ///< to each reader
  in_group  ///< to the multicast group of the domain, once for all readers: for what all nodes publish
};

/// The one participant of the process, with its topics. Thread-safe.
class OwnParticipant final : public Participant {
 public:
  /// `others` listens for the participant; with DDS Security, it is the `secured` one. `must_rejoin`: others
  /// do not follow this participant to a new address unless it leaves and joins again.
  OwnParticipant(fast::DomainParticipant* participant, fast::Publisher* publisher,
                 fast::Subscriber* subscriber, std::unique_ptr<wire::Notices> notices,
                 std::unique_ptr<wire::Notices> unreached, std::unique_ptr<KnownParticipants> others,
                 DiscoveryListener* secured, const UdpTransportDescriptor& transport,
                 std::shared_ptr<HostNames> names, os::InterfaceNews news, os::Notice ending,
                 bool must_rejoin);
  ~OwnParticipant() override;
  [[nodiscard]] const std::optional<security::Identity>& identity() const noexcept override {
    return identity_;
  }
  [[nodiscard]] std::uint64_t refused() const noexcept override {
    return filter_->refused.load(std::memory_order_relaxed) + refused_by_readers();
  }
  [[nodiscard]] std::string unresolved() const override { return names_->unresolved(); }
  [[nodiscard]] std::vector<Announced> announced() const override;

  [[nodiscard]] std::string obstacle(const std::string& device) const override;
  [[nodiscard]] std::string rejection_of(const std::string& device) const override;
  /// The status of this device comes from this participant.
  void is_device(const rtps::GuidPrefix_t& participant, const std::string& device);

  /// Returns the object that reports rejected participants and packets.
  [[nodiscard]] wire::Notices& notices() noexcept { return *notices_; }
  /// Returns the listener for found and lost participants; null if DDS Security is off.
  [[nodiscard]] DiscoveryListener* discovery_listener() noexcept { return discovery_listener_; }

  /// Returns the topic of this name, and creates it if necessary. Fails if this process already uses the
  /// topic with another type, or another type with the same name.
  Result<fast::Topic*> topic(const std::string& name, const fast::TypeSupport& type);
  /// Releases a topic that topic() returned; the last release deletes the topic.
  void release(fast::Topic* topic);

  [[nodiscard]] fast::DomainParticipant& participant() noexcept { return *participant_; }
  /// Creates a writer; returns null if DDS fails to create it.
  ///
  /// Only one thread at a time creates or deletes readers and writers. Otherwise Fast DDS 2.9.1 may match a
  /// new writer with a reader that is being deleted, and use the listener that the reader no longer has (Fast
  /// DDS issue 3303).
  fast::DataWriter* make_writer(fast::Topic* topic, const fast::DataWriterQos& qos,
                                fast::DataWriterListener* listener, const fast::StatusMask& mask);
  /// Deletes a writer, which may be null, and sets the pointer to null. Removes the writer's samples first.
  /// Otherwise Fast DDS would free the samples while a heartbeat of the writer is being sent, and would then
  /// search for a freed sample in an endless loop.
  void end(fast::DataWriter*& writer);
  /// Creates a reader; returns null if DDS fails to create it. Waits until Fast DDS handles no packet (see
  /// ReceiveLock). So the caller must not hold a lock for which a listener waits.
  fast::DataReader* make_reader(fast::Topic* topic, fast::DataReaderQos qos,
                                fast::DataReaderListener* listener, const fast::StatusMask& mask,
                                Receives receives);
  /// Deletes a reader, which may be null, and sets the pointer to null.
  void end(fast::DataReader*& reader);

 private:
  void follow_machine(std::stop_token end);
  void follow_interfaces();
  void follow_losses();
  void announce_endpoints();

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
  std::unique_ptr<wire::Notices> unreached_;
  std::unique_ptr<KnownParticipants> others_;  // the participant's listener
  DiscoveryListener* discovery_listener_;      // the same, with DDS Security; null otherwise
  std::shared_ptr<Interfaces> interfaces_;
  std::shared_ptr<PacketFilter> filter_;
  std::shared_ptr<UdpChannels> channels_;
  std::shared_ptr<HostNames> names_;
  std::optional<security::Identity> identity_;
  fast::DomainParticipant* participant_;
  fast::Publisher* publisher_;
  fast::Subscriber* subscriber_;
  std::mutex endpoints_;  // held while a reader or writer is created or deleted
  mutable std::mutex mutex_;
  std::map<std::string, Shared> topics_;
  std::map<std::string, wire::ParticipantNumber> devices_;
  std::map<std::string, Known> types_;
  os::InterfaceNews news_;
  os::Notice ending_;
  const bool must_rejoin_;
  bool has_moved_ = false;  // an address that others used has disappeared, and none has been added since
  std::jthread machine_;    // calls follow_machine()
};

/// Casts a Participant to OwnParticipant, the only implementation.
OwnParticipant& own(Participant& participant);

/// Returns a number that identifies the writer or reader with this GUID.
std::uint64_t number_of(const rtps::GUID_t& guid);
std::uint64_t number_of(const rtps::InstanceHandle_t& handle);
/// Returns a number that identifies the participant with this GUID prefix.
std::uint64_t number_of(const rtps::GuidPrefix_t& prefix);

/// Returns the name of a QoS policy, such as "reliability".
std::string policy_name(fast::QosPolicyId_t id);

}  // namespace takt::dds
