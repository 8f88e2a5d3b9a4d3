// Who comes and who is turned away, where DDS Security is on. Not for other rooms.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include <takt/dds/inside.hpp>
#include <takt/dds/notices.hpp>
#include <takt/dds/unauthenticated_participants.hpp>
#include <takt/security/identity.hpp>

namespace takt::dds {

/// The identity that a participant announces: "/O=cell/OU=device/CN=robot". None where it is not of that
/// form.
std::optional<security::Subject> announced_subject(std::string_view text);

class Watch final : public fast::DomainParticipantListener {
 public:
  /// The notices and unauthenticated outlive it.
  Watch(security::Identity mine, Notices& notices, UnauthenticatedParticipants& unauthenticated)
      : mine_(std::move(mine)), notices_(notices), newcomers_(unauthenticated) {}

  [[nodiscard]] const security::Identity& mine() const noexcept { return mine_; }

  /// Whether the writer belongs to this device of our cell: its number is bound to its identity.
  bool is_device(const rtps::GUID_t& writer, const std::string& device);
  /// A sample that its writer had no right to say, about `path` on `topic`; told once.
  void impostor(const rtps::GUID_t& writer, const std::string& topic, const std::string& path);
  /// Whether a message of Fast DDS's log says that somebody writes or reads what he was not granted. Nothing
  /// else says so.
  bool look(const std::string& message);
  /// Who a participant is, in words: "observer eve at 10.77.0.3".
  [[nodiscard]] std::string who(const rtps::GuidPrefix_t& prefix);
  void tell(const std::string& text) { notices_.tell(text); }

 private:
  struct Seen {
    std::string name;
    std::string address;
    std::string subject;  // as announced
    std::string authority;
  };

  void turned_away(const rtps::GuidPrefix_t& prefix);
  void on_participant_discovery(fast::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& info) override;
  void onParticipantAuthentication(fast::DomainParticipant*,
                                   rtps::ParticipantAuthenticationInfo&& info) override;

  security::Identity mine_;
  Notices& notices_;
  UnauthenticatedParticipants& newcomers_;
  std::mutex mutex_;
  std::map<rtps::GuidPrefix_t, Seen> seen_;
  std::map<std::string, security::Prefix> prefixes_;  // of devices
};

}  // namespace takt::dds
