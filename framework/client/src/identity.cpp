#include <takt/client/identity.hpp>

#include <cstdio>

#include <takt/core/words.hpp>
#include <takt/os/clock.hpp>
#include <takt/security/choice.hpp>
#include <takt/security/identity.hpp>

namespace takt::client {

using security::Role;

Result<std::string> identity_of(const Network& network) {
  const std::string given = security_of(network);
  if (given.empty()) return given;
  const std::int64_t now = os::wall_ns() / 1'000'000'000;
  const security::Chosen chosen = security::first_of(given, Role::operator_, now);
  const auto identity = security::read_identity(chosen.folder, now);
  if (!identity) return identity.problems();
  const security::Subject& subject = identity->subject;
  if (!chosen.passed_over.empty()) {
    // Do not print the fixes of these problems, because a revoked operator should not be told how to get a
    // new certificate.
    for (const Problem& problem : chosen.passed_over)
      std::fprintf(stderr, "%s\n", on_one_line(problem.where + ": " + problem.what).c_str());
    std::fprintf(stderr, "using the identity of operator %s instead\n", subject.name.c_str());
  }
  if (subject.role == Role::operator_ || subject.role == Role::observer) return chosen.folder;
  return Problem{chosen.folder,
                 std::string{"this is the identity of "} + to_text(subject.role) + " " + subject.name +
                     ", not of an operator or observer",
                 "give the identity folder of an operator or observer, such as DIR/operators/NAME"};
}

Result<void> check_identity(const dds::Participant& participant) {
  const auto& identity = participant.identity();
  if (!identity || os::wall_ns() / 1'000'000'000 < identity->until) return {};
  const security::Subject& subject = identity->subject;
  return Problem{
      identity->folder,
      std::string{"nodes no longer accept the identity of "} + to_text(subject.role) + " " + subject.name +
          ": " + security::expired_text(identity->until),
      "run takt secure renew DIR " + subject.name + ", copy its folder again and restart this program"};
}

Result<void> may_write(const dds::Participant& participant, const std::string& what) {
  const auto& identity = participant.identity();
  if (!identity || identity->subject.role != Role::observer) return {};
  return Problem{identity->folder, "observer " + identity->subject.name + " may only observe, not " + what,
                 "give the identity folder of an operator, such as DIR/operators/NAME"};
}

}  // namespace takt::client
