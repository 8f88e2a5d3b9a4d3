// Replaces the instance of a running module by a new one. The host makes the replacement, and the lifecycle
// state does not change. An error of the new instance affects the old instance only if the error ends the
// host.
#include <utility>

#include <takt/supervision/supervisor.hpp>
#include "forces.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"
#include "properties.hpp"

namespace takt::supervision {

using channel::Doing;
using lifecycle::State;

namespace {

/// Returns the commands that lead a module from `state` to EXECUTING, as advice for an operator.
std::string way_to_executing(State state, const std::string& module) {
  const std::string start = "takt start " + module;
  switch (state) {
    case State::recover:
      return "wait until it has recovered, or run takt recover " + module;
    case State::idle:
      return "run takt initialize " + module + ", then " + start;
    case State::destruct:
      return "run takt reset " + module + ", then takt initialize " + module + ", then " + start;
    default:
      return "run " + start;
  }
}

}  // namespace

Result<void> Supervisor::may_swap(std::uint32_t module) const {
  const Member& member = *members_.at(module);
  const std::string name = "module " + device().name + "." + member.model.name;
  if (member.is_process())
    return fail(name + " is a program; only a thread module can be swapped while it runs",
                "replace its file, and run takt deploy CELL --update, which restarts the device");
  if (member.model.operation != model::Operation::periodic)
    return fail(name + " is " + model::to_text(member.model.operation) +
                    "; only a periodic module can be swapped while it runs",
                "stop it, replace its file, then destruct, reset, initialize and start it");
  if (phase_ != Phase::running) return fail("the device is not running");
  if (member.state() != State::executing)
    return fail(
        name + " is in " + lifecycle::to_text(member.state()) + "; it can be swapped only in EXECUTING",
        way_to_executing(member.state(), device().name + "." + member.model.name));
  if (member.command)
    return fail(std::string{name_of(member.command->verb)} + " is still in progress", "try again later");
  if (member.swap) return fail("a swap of " + name + " is still in progress", "try again later");
  if (properties_->busy(member))
    return fail("a property of " + name + " is being read or set", "try again later");
  return {};
}

void Supervisor::swap(std::uint32_t module, const std::string& path,
                      const std::map<std::string, std::string>& values,
                      std::function<void(const Outcome&)> done) {
  Member& member = *members_.at(module);
  if (const auto may = may_swap(module); !may) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = in_words(may.problems())});
    return;
  }
  log(member, "command: swap to " + path);
  forces_->end_all(member, "the module is swapped");
  member.swap = PendingSwap{.path = path, .values = values, .done = std::move(done)};
  host_of(member).process->ask({.what = host::Request::Do::swap,
                                .module = module,
                                .hook = Doing::load,
                                .value = path,
                                .values = values});  // if the host has ended, host_ended() answers
}

void Supervisor::end_swap(Member& member, ReplyCode code, const std::string& text) {
  if (!member.swap) return;
  const PendingSwap swap = *std::exchange(member.swap, std::nullopt);
  if (code == REPLY_OK) {
    // If the host restarts, it loads the new component.
    parts_.paths.at(member.index) = swap.path;
    log(member, "runs " + swap.path + " " + text);
    for (const auto& [name, value] : swap.values) keep_property(member, name, value);
  } else {
    log(member, "swap failed: " + text);
  }
  swap.done({.code = code, .state = member.state(), .text = text});
}

// Detects a hook of the new instance that does not return.
void Supervisor::check_swaps(Hosted& host) {
  const channel::Activity& activity = host.block.swap;
  Member* const member = member_at(activity.module.load(std::memory_order_acquire) - 1);
  if (member == nullptr || !member->swap || lasted(from_ns(activity.since_ns.load())) <= kHookLimit) return;
  host.process->ask({.what = host::Request::Do::give_up_swap, .module = member->index});
  end_swap(
      *member, REPLY_FAILED,
      std::string{channel::to_text(activity.doing.load())} + " did not return within " + to_text(kHookLimit));
}

bool Supervisor::by_swap(const Member& member, Doing doing) {
  if (!member.swap) return false;
  if (member.block.on_trial.load() != 0) return true;
  return doing == Doing::load || doing == Doing::initialize || doing == Doing::start ||
         doing == Doing::destruct || doing == Doing::thread;
}

}  // namespace takt::supervision
