#include "health.hpp"

#include <algorithm>

#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using model::FaultKind;

PortHealth Health::of(const Member& member, const model::Port& port, Instant now) const {
  const auto on_dds = [this](std::size_t link) { return flows_ ? flows_->health(link) : std::nullopt; };
  PortHealth health = parts_.wiring.health(member.index, port, to_ns(now), on_dds, is_lost_);
  if (const auto noted = noted_ports_.find({member.index, port.name}); noted != noted_ports_.end())
    health.losing = noted->second.losses.rises(now.time_since_epoch());
  for (std::size_t i = 0; i < noted_queues_.size(); ++i) {
    const PlannedLink& plan = parts_.wiring.links()[i].plan;
    const LinkEnd here{member.index, port.name};
    if (plan.from == here || plan.to == here)
      health.dropping |= noted_queues_[i].drops.rises(now.time_since_epoch());
  }
  const auto at_stop = matched_at_stop_.find({member.index, port.name});
  if (at_stop != matched_at_stop_.end()) health.matched = at_stop->second;
  return health;
}

std::optional<wire::Judgement> Health::judge(const model::Port& port, const PortHealth& health) const {
  // Before its first row and after its last one, a device passes on no samples, and its values grow old.
  if (stopped_ || ports_watched_at_ == Instant{} || health.connections == 0) return std::nullopt;
  wire::ConnectionReport report{.matched = health.matched > 0 && health.missing == 0,
                                .outside = health.missing == 0,
                                .output = port.direction == model::Direction::out,
                                .safe = health.safe,
                                .age = std::nullopt,
                                .deadline = health.deadline,
                                .losing = health.losing,
                                .dropping = health.dropping,
                                .incompatible = health.incompatible,
                                .forced = health.forced};
  if (health.age_ns >= 0) report.age = Nanoseconds{health.age_ns};
  return wire::judge(report);
}

void Health::check_counts() {
  for (const auto& member : members_) {
    const bool sporadic = member->model.operation == model::Operation::sporadic;
    notes_.note_increase(
        member.get(), FaultKind::overrun, noted_overruns_[member->index], member->overruns(),
        sporadic ? "it was not finished by its deadline" : "it was not finished by its next release");
  }
  noted_missed_.resize(parts_.channel.executors());
  for (std::size_t e = 0; e < noted_missed_.size(); ++e) {
    const std::string& name = parts_.of_device().executors[e].name;
    notes_.note_increase(nullptr, FaultKind::missed_rows, noted_missed_[e],
                         parts_.channel.executor(e).missed.load(std::memory_order_relaxed),
                         "executor " + name + " skipped rows that it could not begin in time", name);
  }
}

void Health::check_ports(Instant now) {
  if (now - ports_watched_at_ < kPortsEvery) return;
  ports_watched_at_ = now;
  for (const auto& member : members_) {
    const model::ModulePorts& ports = parts_.ports.at(member->index);
    if (!ports) continue;
    for (const model::Port& port : *ports) check_port(*member, port, now);
  }
  check_queues(now);
}

void Health::check_queues(Instant now) {
  const auto& links = parts_.wiring.links();
  noted_queues_.resize(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Wiring::CreatedLink& link = links[i];
    const channel::LinkBlock& block = link.link.block();
    if (!link.connected() || block.is_queue == 0) continue;
    NotedQueue& noted = noted_queues_[i];
    const std::uint64_t before =
        std::exchange(noted.dropped, block.overwritten.load(std::memory_order_relaxed));
    if (!noted.drops.update(noted.dropped, now.time_since_epoch())) continue;
    const bool has_reader = link.plan.to.module.has_value();
    const LinkEnd& end = has_reader ? link.plan.to : link.plan.from;
    std::uint64_t seen = before;
    notes_.note_increase(members_[*end.module].get(), FaultKind::dropped_samples, seen, noted.dropped,
                         std::string{"the queue "} +
                             (has_reader ? "of input '" : "between the network and output '") + end.port +
                             "' is full and drops its oldest samples",
                         end.port);
  }
}

void Health::check_port(const Member& member, const model::Port& port, Instant now) {
  const PortHealth health = of(member, port, now);
  NotedPort& noted = noted_ports_[{member.index, port.name}];
  const std::string name = "'" + port.name + "'";
  const auto note_once = [&](FaultKind kind, const std::string& cause) {
    std::uint64_t seen = 0;
    notes_.note_increase(&member, kind, seen, 1, cause, port.name);
  };

  noted.losses.update(health.lost, now.time_since_epoch());
  if (port.direction != model::Direction::out) {
    if (health.late > noted.late) noted.stale = true;
    notes_.note_increase(&member, FaultKind::stale_input, noted.late, health.late,
                         "the newest value of input " + name + " is older than its deadline", port.name);
  }
  const bool late =
      std::any_of(member.inputs.begin(), member.inputs.end(), [&](const Wiring::CreatedLink* created) {
        const std::int64_t newest = created->link.block().newest_ns.load(std::memory_order_relaxed);
        return created->plan.to.port == port.name &&
               now - from_ns(newest) > Nanoseconds{created->plan.options.deadline_ns} &&
               !created->link.is_forced(to_ns(now));
      });
  if (noted.stale && !late) {
    noted.stale = false;
    note_once(FaultKind::fresh_input, "input " + name + " has new values");
  }

  notes_.note_increase(&member, FaultKind::refused_packet, noted.refused, health.refused,
                       "a sample at port " + name + " did not fit the port's type", port.name);

  const std::uint32_t before = std::exchange(noted.matched, health.matched);
  if (health.matched < before) {
    noted.lost = true;
    const std::uint32_t unmatched = health.connections - std::min(health.matched, health.connections);
    note_once(FaultKind::connection_lost, "port " + name + ": the other end of " + std::to_string(unmatched) +
                                              " of " + std::to_string(health.connections) +
                                              " connections is unavailable");
  } else if (health.matched > before && noted.lost) {
    noted.lost = health.matched < health.connections;
    note_once(FaultKind::connection_back,
              "port " + name + ": the other end of a connection is available again");
  }
}

void Health::stop(Instant now) {
  stopped_ = true;
  for (const auto& member : members_) {
    const model::ModulePorts& ports = parts_.ports.at(member->index);
    if (!ports) continue;
    for (const model::Port& port : *ports)
      matched_at_stop_[{member->index, port.name}] = of(*member, port, now).matched;
  }
}

void Health::finish(Instant now) {
  check_counts();
  ports_watched_at_ = {};
  check_ports(now);
}

}  // namespace takt::supervision
