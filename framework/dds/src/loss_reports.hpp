// With DDS Security, lets two participants find each other again after only one of them has lost the other.
//
// A participant that receives nothing of another one for the lease loses it, with its keys, and authenticates
// it again when it receives an announcement. But if the other one has not lost the first, because packets
// were lost in one direction only, or a little later, it ignores the authentication: it has authenticated the
// first one already. And it never loses the first one, because it receives its announcements, which are not
// encrypted. So the first one reports the loss. Anybody could forge such a report. So it is believed only if
// it is repeated, and if nothing encrypted comes from its sender meanwhile. After a forged report that is
// believed, the other side reports the loss in turn, and both authenticate again. Only the source files of
// this room include this header.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/os/udp_socket.hpp>
#include <takt/wire/rtps.hpp>

namespace takt::dds {

/// Any thread may call its functions. All times are monotonic.
class LossReports {
 public:
  /// How long an authentication may take before the loss is reported.
  static constexpr Nanoseconds kPatience = std::chrono::seconds{3};
  static constexpr Nanoseconds kReportEvery = std::chrono::seconds{1};
  /// The time over which a report must be repeated.
  static constexpr Nanoseconds kRepeated = std::chrono::seconds{2};
  /// A report about this long after the authentication may come from before it.
  static constexpr Nanoseconds kNew = std::chrono::seconds{5};

  /// A member of the cell has authenticated.
  void authenticated(const wire::ParticipantNumber& member, Instant now);
  /// This participant has lost another one.
  void lost(const wire::ParticipantNumber& member);
  /// A participant has announced that it receives discovery messages here.
  void announced(const wire::ParticipantNumber& participant, const os::UdpEnd& at, Instant now);
  /// Returns the participants to which the loss must be reported now.
  std::vector<std::pair<wire::ParticipantNumber, os::UdpEnd>> due(Instant now);

  /// Somebody reports in the name of this participant that it has lost this one. `heard`: when its last
  /// encrypted message came.
  void reported(const wire::ParticipantNumber& by, std::optional<Instant> heard, Instant now);
  /// Returns the participants that must be forgotten, because they have lost this one.
  std::vector<wire::ParticipantNumber> take_mutual();

 private:
  struct Member {
    Instant since;
    std::optional<Instant> first_report{};
    Instant last_report{};
  };
  struct Lost {
    os::UdpEnd at{};
    std::optional<Instant> first_announcement{};
    Instant last_announcement{};
    Instant last_report{};
  };
  std::mutex mutex_;
  std::map<wire::ParticipantNumber, Member> members_;
  std::map<wire::ParticipantNumber, Lost> lost_;
  std::vector<wire::ParticipantNumber> mutual_;
};

}  // namespace takt::dds
