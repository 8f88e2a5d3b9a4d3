// Detects stale inputs of process modules.
#include <algorithm>

#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using lifecycle::State;

// Checks the inputs of a process module. The host checks the inputs of thread modules, before each run().
void Supervisor::check_inputs(Member& member, Instant now) {
  if (!member.is_process() || member.state() != State::executing || !member.in_tables()) return;
  const Wiring::CreatedLink* stale = nullptr;
  for (Wiring::CreatedLink* created : member.inputs) {
    channel::LinkBlock& block = created->link.block();
    const Instant newest =
        std::max(from_ns(block.newest_ns.load(std::memory_order_relaxed)), member.put_in_at);
    const bool late =
        now - newest > Nanoseconds{created->plan.options.deadline_ns} && !created->link.is_forced(to_ns(now));
    if (late && !created->late) block.late.fetch_add(1, std::memory_order_relaxed);
    created->late = late;
    if (late && created->plan.stale == model::Stale::error && stale == nullptr) stale = created;
  }
  if (stale == nullptr) return;
  raise(member, ErrorType::stale,
        "the newest value of input '" + stale->plan.to.port + "' is older than " +
            to_text(Nanoseconds{stale->plan.options.deadline_ns}));
}

bool Supervisor::has_stale_input(const Member& member, Instant now) {
  return std::any_of(member.inputs.begin(), member.inputs.end(), [now](const Wiring::CreatedLink* created) {
    if (created->plan.stale != model::Stale::error || created->link.is_forced(to_ns(now))) return false;
    const std::int64_t newest = created->link.block().newest_ns.load(std::memory_order_relaxed);
    return newest == 0 || now - from_ns(newest) > Nanoseconds{created->plan.options.deadline_ns};
  });
}

}  // namespace takt::supervision
