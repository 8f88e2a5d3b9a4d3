// The supervisor's entries in the fault record other than lifecycle events: counts, ports, crashes.
#include <algorithm>

#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using model::FaultKind;

void Supervisor::note(FaultKind kind, const std::string& cause, const std::string& origin) const {
  if (options_.noted) options_.noted({.kind = kind, .cause = cause}, origin);
}

void Supervisor::note(const Member& member, FaultKind kind, const std::string& cause, ErrorType error,
                      const std::string& attachment) const {
  if (!options_.noted) return;
  options_.noted({.module = member.model.name,
                  .kind = kind,
                  .error = error == ErrorType::none ? "" : takt::to_text(error),
                  .cause = cause,
                  .attachment = attachment,
                  .cycle = releases_of(member)},
                 {});
}

// Records the increase of a counter since the last check. A counter that has decreased is ignored: a
// restarted bridge counts from 0.
void Supervisor::note_counts(const Member& member, FaultKind kind, std::uint64_t& seen, std::uint64_t now,
                             const std::string& cause, const std::string& origin) const {
  const std::uint64_t before = std::exchange(seen, now);
  if (now <= before || !options_.noted) return;
  options_.noted({.module = member.model.name,
                  .kind = kind,
                  .cause = cause,
                  .count = now - before,
                  .cycle = releases_of(member)},
                 origin);
}

void Supervisor::watch_counts() {
  for (auto& member : members_) {
    const bool sporadic = member->model.operation == model::Operation::sporadic;
    note_counts(*member, FaultKind::overrun, member->noted_overruns, overruns_of(*member),
                sporadic ? "it was not finished by its deadline" : "it was not finished by its next release");
  }
  seen_missed_.resize(parts_.channel.executors());
  for (std::size_t e = 0; e < parts_.channel.executors(); ++e) {
    const std::uint64_t missed = parts_.channel.executor(e).missed.load(std::memory_order_relaxed);
    const std::uint64_t before = std::exchange(seen_missed_[e], missed);
    const std::string& name = device().executors[e].name;
    if (missed > before && options_.noted) {
      options_.noted({.kind = FaultKind::missed_rows,
                      .cause = "executor " + name + " skipped rows that it could not begin in time",
                      .count = missed - before},
                     name);
    }
  }
}

void Supervisor::watch_ports(Instant now) {
  if (!rows_begun_ || now - ports_watched_at_ < kPortsEvery) return;
  ports_watched_at_ = now;
  for (auto& member : members_) {
    const model::ModulePorts& ports = parts_.ports.at(member->index);
    if (!ports) continue;
    for (const model::Port& port : *ports) watch_port(*member, port, now);
  }
}

void Supervisor::watch_port(Member& member, const model::Port& port, Instant now) const {
  const PortHealth health = health_of(member, port, now);
  NotedPort& noted = member.noted_ports[port.name];
  const std::string name = "'" + port.name + "'";
  const auto note_once = [&](FaultKind kind, const std::string& cause) {
    std::uint64_t seen = 0;
    note_counts(member, kind, seen, 1, cause, port.name);
  };

  if (health.late > noted.late) noted.stale = true;
  note_counts(member, FaultKind::stale_input, noted.late, health.late,
              "the newest value of input " + name + " is older than its deadline", port.name);
  const bool late = std::any_of(member.inputs.begin(), member.inputs.end(), [&](const Wiring::Wire* wire) {
    const std::int64_t newest = wire->link.block().newest_ns.load(std::memory_order_relaxed);
    return wire->plan.to.port == port.name &&
           now - from_ns(newest) > Nanoseconds{wire->plan.options.deadline_ns};
  });
  if (noted.stale && !late) {
    noted.stale = false;
    note_once(FaultKind::fresh_input, "input " + name + " has new values");
  }

  note_counts(member, FaultKind::refused_packet, noted.refused, health.refused,
              "a sample at port " + name + " did not fit the port's type", port.name);

  const std::uint32_t before = std::exchange(noted.matched, health.matched);
  if (health.matched < before) {
    noted.lost = true;
    const std::uint32_t unmatched = health.connections - std::min(health.matched, health.connections);
    note_once(FaultKind::connection_lost, "port " + name + ": the other end of " + std::to_string(unmatched) +
                                              " of " + std::to_string(health.connections) +
                                              " connections is not there");
  } else if (health.matched > before && noted.lost) {
    noted.lost = health.matched < health.connections;
    note_once(FaultKind::connection_back, "port " + name + ": the other end of a connection is back");
  }
}

}  // namespace takt::supervision
