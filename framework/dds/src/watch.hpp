// Observes the participants that join a cell with DDS Security, and reports each rejected participant and the
// reason. For the source files of this room only.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include "inside.hpp"
#include <takt/wire/notices.hpp>
#include <takt/wire/unauthenticated_participants.hpp>
#include <takt/security/identity.hpp>

namespace takt::dds {

/// Parses the identity that a participant announces, such as "/O=cell/OU=device/CN=robot". Returns
/// std::nullopt if the text does not have this form.
std::optional<security::Subject> announced_subject(std::string_view text);

class Watch final : public fast::DomainParticipantListener {
 public:
  /// `notices` and `unauthenticated` must outlive this object.
  Watch(security::Identity mine, wire::Notices& notices, wire::UnauthenticatedParticipants& unauthenticated)
      : mine_(std::move(mine)), notices_(notices), unauthenticated_(unauthenticated) {}

  [[nodiscard]] const security::Identity& mine() const noexcept { return mine_; }

  /// Returns whether the writer belongs to this device of the cell. The writer's GUID proves this, because it
  /// contains a hash of the device's identity.
  bool is_device(const rtps::GUID_t& writer, const std::string& device);
  /// Reports that a writer published a sample on `topic` about `path` without permission. The same report is
  /// made only once.
  void impostor(const rtps::GUID_t& writer, const std::string& topic, const std::string& path);
  /// Reads a message from the log of Fast DDS. If it says that a participant uses a topic without permission,
  /// reports this and returns true. Fast DDS reports this only in its log.
  bool look(const std::string& message);
  /// Returns a description of a participant, such as "observer eve at 10.77.0.3".
  [[nodiscard]] std::string who(const rtps::GuidPrefix_t& prefix);
  void tell(const std::string& text) { notices_.tell(text); }

 private:
  struct Seen {
    std::string name;
    std::string address;
    std::string subject;  // the identity that it announces
    std::string authority;
  };

  void report_rejected(const rtps::GuidPrefix_t& prefix);
  void on_participant_discovery(fast::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& info) override;
  void onParticipantAuthentication(fast::DomainParticipant*,
                                   rtps::ParticipantAuthenticationInfo&& info) override;

  security::Identity mine_;
  wire::Notices& notices_;
  wire::UnauthenticatedParticipants& unauthenticated_;
  std::mutex mutex_;
  std::map<rtps::GuidPrefix_t, Seen> seen_;
  std::map<std::string, security::Prefix> prefixes_;  // GUID prefixes of devices, by device name
};

}  // namespace takt::dds
