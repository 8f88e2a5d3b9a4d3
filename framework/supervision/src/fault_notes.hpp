// The supervisor's entries in the fault record.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <takt/component.hpp>
#include <takt/model/fault.hpp>

namespace takt::supervision {

struct Member;

class FaultNotes {
 public:
  /// `origin` names the port or executor to which the event refers. It is empty if the event refers to
  /// neither.
  using Noted = std::function<void(model::Fault, const std::string& origin)>;

  explicit FaultNotes(Noted noted) : noted_(std::move(noted)) {}

  /// Records an event of the device.
  void note(model::FaultKind kind, const std::string& cause) const;
  void note(const Member& member, model::FaultKind kind, const std::string& cause,
            ErrorType error = ErrorType::none, const std::string& attachment = {}) const;
  /// Records a log line of a module, or a line about it. `release` is the number of the release in which the
  /// module logged the line; 0 if there is none. `time_ns` is on the monotonic clock; 0 means now.
  void note_line(const Member& member, model::FaultKind kind, const std::string& text,
                 std::uint64_t release = 0, std::int64_t time_ns = 0) const;
  /// Records the increase of a counter from `seen` to `now`, and sets `seen` to `now`. Ignores a decrease,
  /// because a restarted bridge counts from 0. `member` is null for a counter of the device.
  void note_increase(const Member* member, model::FaultKind kind, std::uint64_t& seen, std::uint64_t now,
                     const std::string& cause, const std::string& origin = {}) const;

 private:
  Noted noted_;
};

}  // namespace takt::supervision
