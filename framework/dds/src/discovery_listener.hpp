// Observes the participants that join and leave. In a cell with DDS Security, also reports each rejected
// participant and the reason. Only the source files of this room include this header.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <takt/security/identity.hpp>
#include <takt/security/revocations.hpp>
#include <takt/wire/notices.hpp>
#include "inside.hpp"
#include "loss_reports.hpp"
#include "packet_filter.hpp"

namespace takt::dds {

/// Parses the identity that a participant announces, such as "/O=cell/OU=device/CN=robot". Returns
/// std::nullopt if the text does not have this form.
std::optional<security::Subject> announced_subject(std::string_view text);

/// Knows the participants that this one has found and not lost. Any thread may call its functions.
class KnownParticipants : public ParticipantListener {
 public:
  /// Returns the name of each participant, without this one.
  [[nodiscard]] std::map<wire::ParticipantNumber, std::string> names() const;

 protected:
  void lost(const rtps::GuidPrefix_t& participant) override;

 private:
  void found(const rtps::GuidPrefix_t& participant, const std::string& name) final;
  void authenticated(const rtps::GuidPrefix_t&, bool) override {}

  mutable std::mutex names_mutex_;
  std::map<wire::ParticipantNumber, std::string> names_;
};

class DiscoveryListener final : public KnownParticipants {
 public:
  /// `notices` and `filter` must outlive this object.
  DiscoveryListener(security::Identity mine, wire::Notices& notices, PacketFilter& filter)
      : mine_(std::move(mine)), notices_(notices), filter_(filter), revocations_(mine_.folder) {
    static_cast<void>(revocations_.update());  // mine_ was read with the same file
  }

  [[nodiscard]] const security::Identity& mine() const noexcept { return mine_; }

  /// Returns true if the writer belongs to this device of the cell. The writer's GUID proves this, because
  /// the GUID contains a hash of the device's identity.
  bool is_device(const rtps::GUID_t& writer, const std::string& device);
  /// Reports that a writer published a sample on `topic` about `path` without permission. Makes the same
  /// report only once.
  void impostor(const rtps::GUID_t& writer, const std::string& topic, const std::string& path);
  /// Reads a message from the log of Fast DDS. If the message states that a participant uses a topic without
  /// permission, reports the participant and returns true. Fast DDS reports such a participant only in its
  /// log.
  bool look(const std::string& message);
  /// Returns a description of a participant, such as "observer eve at 10.77.0.3".
  [[nodiscard]] std::string who(const rtps::GuidPrefix_t& prefix);
  void tell(const std::string& text) { notices_.tell(text); }

  /// Notes what a participant announces of itself, and where its announcement comes from.
  void announced(const wire::Announcement& announcement, const os::Ipv4& from);
  /// Notes the certificate of a participant that has authenticated. Rejects the participant if the
  /// certificate was revoked since this process began.
  void certified(const rtps::GuidPrefix_t& participant, const x509_st& certificate);
  /// Reads the list of revoked certificates again if it has changed. Rejects and reports the participants
  /// whose certificate has expired at the time `now` (in seconds since 1970) or was revoked.
  void check_certificates(std::int64_t now);
  /// Returns a sentence that says why this participant no longer accepts the device; empty if it accepts it.
  [[nodiscard]] std::string rejection_of(const std::string& device);

  LossReports losses;

 private:
  struct Certificate {
    security::Certified says;
    bool rejected = false;
  };
  struct Seen {
    std::string name;
    std::string address;  // where its first announcement came from
    std::string subject;  // the identity that the participant announces
    std::string authority;
  };

  /// Returns why a certificate is no longer accepted; empty if it is.
  [[nodiscard]] std::string invalidity(const security::Certified& certificate, std::int64_t now) const;
  void reject_invalid(std::int64_t now);
  void report_rejected(const rtps::GuidPrefix_t& prefix);
  void lost(const rtps::GuidPrefix_t& participant) override;
  void authenticated(const rtps::GuidPrefix_t& participant, bool accepted) override;

  security::Identity mine_;
  wire::Notices& notices_;
  PacketFilter& filter_;
  std::mutex mutex_;
  security::Revocations revocations_;
  bool mine_is_revoked_ = false;
  std::map<rtps::GuidPrefix_t, Seen> seen_;
  std::map<rtps::GuidPrefix_t, Certificate> certificates_;  // of the participants that have authenticated
  std::map<std::string, std::string> rejections_;           // why devices are rejected, by device name
  std::map<std::string, security::Prefix> prefixes_;        // GUID prefixes of devices, by device name
};

}  // namespace takt::dds
