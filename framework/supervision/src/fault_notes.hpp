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
  /// `origin` names the port or executor that the event is about; empty if it is about neither.
  using Noted = std::function<void(model::Fault, const std::string& origin)>;

  explicit FaultNotes(Noted noted) : noted_(std::move(noted)) {}

  /// Records an event of the device.
  void note(model::FaultKind kind, const std::string& cause) const;
  void note(const Member& member, model::FaultKind kind, const std::string& cause,
            ErrorType error = ErrorType::none, const std::string& attachment = {}) const;
  /// Records the increase of a counter since the last check. Ignores a counter that has decreased, because a
  /// restarted bridge counts from 0. `member` is null for the device.
  void note_increase(const Member* member, model::FaultKind kind, std::uint64_t& seen, std::uint64_t now,
                     const std::string& cause, const std::string& origin = {}) const;

 private:
  Noted noted_;
};

}  // namespace takt::supervision
