// Reads and sets properties of modules while the device runs. The host holds the properties of thread
// modules; a process module receives its properties as arguments when it starts.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include <takt/host/protocol.hpp>
#include <takt/supervision/supervised.hpp>

namespace takt::supervision {

struct Hosted;
struct Member;

/// The requests for properties that hosts have not answered yet.
class Properties {
 public:
  using Done = std::function<void(const Outcome&)>;

  /// True if a property of the module is being read or set.
  [[nodiscard]] bool busy(const Member& member) const;
  /// Sends the request to the module's host. If the host has already ended, the next call of fail() answers
  /// the request.
  void ask(const Member& member, const Hosted& host, host::Request request, Done done);
  /// Passes a host's answer to the function that waits for this answer. Returns the module whose property was
  /// set, or null.
  const Member* answered(const host::Answer& answer);
  /// Answers all requests to the modules of a host that has ended, with the reason `why`.
  void fail(const Hosted& host, const std::string& why);

 private:
  struct Waiting {
    const Member* member;
    const Hosted* host;
    Done done;
  };
  std::map<std::uint64_t, Waiting> waiting_;
  std::uint64_t asked_ = 0;
};

}  // namespace takt::supervision
