// Another instance of a module takes the place of the one that runs: done by the host, over in the
// lifecycle's eyes before it has begun. What goes wrong with the new one costs the old one nothing but, where
// it ends the host, what that costs everybody.
#include <utility>

#include <takt/node/supervisor.hpp>
#include <takt/os/clock.hpp>
#include "limits.hpp"

namespace takt::node {

using channel::Doing;
using lifecycle::State;

Result<void> Supervisor::may_swap(std::uint32_t module) const {
  const Member& member = *members_.at(module);
  const std::string name = "module " + device().name + "." + member.model.name;
  if (member.is_process())
    return fail(name + " is a program; only a thread module can be swapped while it runs",
                "undeploy the cell, replace the program and deploy the cell again");
  if (member.model.operation != model::Operation::periodic)
    return fail(name + " is " + model::to_text(member.model.operation) +
                    "; only a periodic module can be swapped while it runs",
                "stop it, replace its file, then destruct, reset, initialize and start it");
  if (phase_ != Phase::running) return fail("the device does not run");
  if (member.state() != State::executing)
    return fail(
        name + " is in " + lifecycle::to_text(member.state()) + "; it can be swapped in EXECUTING alone",
        "takt start " + device().name + "." + member.model.name);
  if (member.order)
    return fail(std::string{name_of(member.order->verb)} + " is still under way", "ask again");
  if (member.swap) return fail("a swap of " + name + " is still under way", "ask again");
  for (const auto& [id, request] : property_requests_) {
    if (request.module == module) return fail("a property of " + name + " is just being set", "ask again");
  }
  return {};
}

void Supervisor::swap(std::uint32_t module, const std::string& path,
                      std::function<void(const Outcome&)> done) {
  Member& member = *members_.at(module);
  if (const auto may = may_swap(module); !may) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = in_words(may.problems())});
    return;
  }
  log(member, "swap to " + path + " was ordered");
  member.swap = SwapOrder{.path = path, .done = std::move(done)};
  host_of(member).link.ask({.what = host::Request::Do::swap,
                            .module = module,
                            .hook = Doing::load,
                            .value = path});  // when the host is gone, host_ended() answers
}

void Supervisor::end_swap(Member& member, ReplyCode code, const std::string& text) {
  if (!member.swap) return;
  const SwapOrder swap = *std::exchange(member.swap, std::nullopt);
  if (code == REPLY_OK) {
    // A host that is started again loads it too.
    options_.paths.at(member.index) = swap.path;
    log(member, "runs " + swap.path + " " + text);
  } else {
    log(member, "swap failed: " + text);
  }
  swap.done({.code = code, .state = member.state(), .text = text});
}

// A hook of the new instance that never comes back.
void Supervisor::watch_swaps(Hosted& host, Instant now) {
  const channel::Activity& activity = host.block.swap;
  Member* const member = member_at(activity.module.load(std::memory_order_acquire) - 1);
  if (member == nullptr || !member->swap || now - from_ns(activity.since_ns.load()) <= kHookLimit) return;
  host.link.ask({.what = host::Request::Do::give_up_swap, .module = member->index});
  end_swap(
      *member, REPLY_FAILED,
      std::string{channel::to_text(activity.doing.load())} + " did not return within " + to_text(kHookLimit));
}

bool Supervisor::by_swap(const Member& member, Doing doing) {
  if (!member.swap) return false;
  if (member.block.on_trial.load() != 0) return true;
  return doing == Doing::load || doing == Doing::initialize || doing == Doing::start ||
         doing == Doing::destruct;
}

}  // namespace takt::node
