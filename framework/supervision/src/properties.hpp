// Reads and sets properties of modules while the device runs. A host holds the properties of its thread
// modules, and the program of a process module its own.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include <takt/core/time.hpp>
#include <takt/host/protocol.hpp>
#include <takt/supervision/supervised.hpp>

namespace takt::supervision {

struct Hosted;
struct Member;

/// The requests for properties that hosts and programs have not answered yet.
class Properties {
 public:
  using Done = std::function<void(const Outcome&)>;

  /// True if a property of the module is being read or set.
  [[nodiscard]] bool busy(const Member& member) const;
  /// Sends the request to the module's host. If the host has already ended, the next call of fail() answers
  /// the request.
  void ask(const Member& member, const Hosted& host, host::Request request, Done done);
  /// Sends the request to the module's program as soon as the program has answered the earlier requests. If
  /// there is no answer until `limit`, expire() answers the request.
  void ask(const Member& member, Instant limit, host::Request request, Done done);
  /// Sends the module's program its next request. Returns the program's next answer, or nothing.
  std::optional<host::Answer> take_answer(const Member& member);
  /// Passes an answer of a host or a program to the function that waits for it.
  void answered(const host::Answer& answer);
  /// Answers all requests to the modules of a host that has ended, with the reason `why`.
  void fail(const Hosted& host, const std::string& why);
  /// Answers all requests to a module whose program has ended, with the reason `why`.
  void fail(const Member& member, const std::string& why);
  /// Answers the requests that a program has not answered in time.
  void expire(Instant now);

 private:
  struct Waiting {
    const Member* member;
    const Hosted* host;              // null if a program is asked
    std::optional<Instant> limit{};  // only if a program is asked
    bool sets = false;
    Done done;
  };
  /// The requests to one program, the oldest first. A request that has been sent stays at the front until the
  /// program answers it, even after its limit.
  struct Queue {
    std::deque<host::Request> requests;
    bool sent = false;  // true if the first request is in the program's release slot
  };
  /// Answers the waiting requests for which `fails` is true. `why` returns the reason; its second argument is
  /// true if the host or the program may still carry out the request.
  template <class Fails, class Why>
  void fail_if(const Fails& fails, const Why& why);

  std::map<std::uint64_t, Waiting> waiting_;
  std::map<const Member*, Queue> queues_;
  std::uint64_t asked_ = 0;
};

}  // namespace takt::supervision
