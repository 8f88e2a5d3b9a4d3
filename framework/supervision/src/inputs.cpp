// Detects stale inputs of programs.
#include <algorithm>

#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using lifecycle::State;

// Checks the inputs of a program. The host checks those of thread modules itself, before each run().
void Supervisor::watch_inputs(Member& member, Instant now) {
  if (!member.is_process() || member.state() != State::executing || !member.in_tables()) return;
  const Wiring::Wire* stale = nullptr;
  for (Wiring::Wire* wire : member.inputs) {
    channel::LinkBlock& block = wire->link.block();
    const Instant newest =
        std::max(from_ns(block.newest_ns.load(std::memory_order_relaxed)), member.put_in_at);
    const bool late = now - newest > Nanoseconds{wire->plan.options.deadline_ns};
    if (late && !wire->late) block.late.fetch_add(1, std::memory_order_relaxed);
    wire->late = late;
    if (late && wire->plan.stale == model::Stale::error && stale == nullptr) stale = wire;
  }
  if (stale == nullptr) return;
  ++member.errors;
  raise(member, ErrorType::stale,
        "the newest value of input '" + stale->plan.to.port + "' is older than " +
            to_text(Nanoseconds{stale->plan.options.deadline_ns}));
}

bool Supervisor::has_stale_input(const Member& member, Instant now) {
  return std::any_of(member.inputs.begin(), member.inputs.end(), [now](const Wiring::Wire* wire) {
    if (wire->plan.stale != model::Stale::error) return false;
    const std::int64_t newest = wire->link.block().newest_ns.load(std::memory_order_relaxed);
    return newest == 0 || now - from_ns(newest) > Nanoseconds{wire->plan.options.deadline_ns};
  });
}

}  // namespace takt::supervision
