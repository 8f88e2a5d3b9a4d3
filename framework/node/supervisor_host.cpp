// The host of a device: started, asked, watched, started again.
#include <algorithm>

#include <takt/core/check.hpp>
#include <takt/node/limits.hpp>
#include <takt/node/supervisor.hpp>
#include <takt/os/clock.hpp>

namespace takt::node {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

Result<void> Supervisor::start_host() {
  host::Setup setup{.device = device(),
                    .paths = options_.paths,
                    .executor_cpus = placement_.executors,
                    .background_cpus = placement_.background,
                    .seat_fds = {},
                    .bell_fd = bell_memory_.fd().get(),
                    .links = wiring_.of_host(device())};
  std::vector<const os::Fd*> inherit{&bell_memory_.fd()};
  for (const auto& member : members_) {
    setup.seat_fds.push_back(member->seat == nullptr ? -1 : member->seat_memory.fd().get());
    if (member->seat != nullptr) inherit.push_back(&member->seat_memory.fd());
  }
  wiring_.inherit(inherit, setup.links);
  std::vector<std::pair<std::string, std::string>> environment;
  if (violations_) environment = violations_->environment(inherit);
  return host_.start(channel_, setup, inherit, environment);
}

void Supervisor::ask(Member& member, Doing hook, ErrorType type) {
  TAKT_CHECK(!member.lost);
  member.pending = hook;
  host_.ask({.what = host::Request::Do::call,
             .module = member.index,
             .hook = hook,
             .error_type = static_cast<int>(type)});
}

void Supervisor::take_answers() {
  while (auto answer = host_.answer()) {
    switch (answer->request.what) {
      case host::Request::Do::call: {
        Member& member = *members_.at(answer->request.module);
        if (member.lost || member.pending != answer->request.hook) break;  // it was given up in the meantime
        member.pending.reset();
        answered(member, answer->request.hook, answer->ok, answer->text);
        break;
      }
      case host::Request::Do::get:
      case host::Request::Do::set:
        property_answered(*answer);
        break;
      case host::Request::Do::begin:
        for (const std::string& warning : answer->warnings) {
          real_time_ = false;
          log("WARNING: not real-time: " + warning);
        }
        if (!answer->ok) fail_device(fail(answer->text));
        break;
      case host::Request::Do::halt:
        halted_ = true;
        break;
      case host::Request::Do::background:
      case host::Request::Do::give_up:
      case host::Request::Do::end:
        break;
    }
  }
}

void Supervisor::answered(Member& member, Doing hook, bool ok, const std::string& text) {
  const std::string failure = std::string{channel::to_text(hook)} + " failed: " + text;
  switch (hook) {
    case Doing::load:
      if (!ok && member.state() == State::destruct) {  // it was to be reset
        member.lost = true;
        member.why = failure;
      } else if (!ok) {
        lose(member, failure);
      } else {
        if (member.state() == State::destruct) apply(member, Event::reset);
        if (member.up_to != State::idle) ask(member, Doing::initialize);
      }
      break;
    case Doing::initialize:
      if (!ok) {
        lose(member, failure);
        break;
      }
      apply(member, Event::initialize);
      // While the device is prepared, all are initialised before the first is started; one that comes back
      // waits for nobody.
      if ((phase_ == Phase::ready || phase_ == Phase::running) && member.up_to != State::initialize)
        ask(member, Doing::start);
      break;
    case Doing::start:
      if (ok && member.state() == State::recover)
        recovered(member);
      else if (ok)
        apply(member, Event::start);
      else if (member.state() == State::recover)
        not_recovered(member, failure);
      else
        raise(member, ErrorType::start, failure);
      // A module that comes back with a new host goes on where it was.
      if (ok && rows_begun_ && member.state() == State::start && member.wanted()) put_in_tables(member);
      break;
    case Doing::error:
      if (!ok) log(member, failure);
      break;
    case Doing::recover:
      if (!ok)
        not_recovered(member, failure);
      else if (member.machine.previous() == State::initialize)
        ask(member, Doing::start);  // what failed was start()
      else
        recovered(member);
      break;
    case Doing::destruct:
      if (!ok) log(member, failure);
      if (member.machine.accepts(Event::destruct)) apply(member, Event::destruct);
      break;
    case Doing::nothing:
    case Doing::run:
    case Doing::condition:
    case Doing::serve:
      break;
  }
}

void Supervisor::begin_rows() {
  for (auto& member : members_) {
    if (member->scheduled() && member->wanted() && member->state() == State::start) put_in_tables(*member);
  }
  rows_begun_ = true;
  host_.ask({.what = host::Request::Do::begin});
}

// A run() or a hook that never comes back.
void Supervisor::watch_host(Instant now) {
  if (!host_.running() || hung_) return;
  const auto since = [now](const channel::Activity& activity) {
    return now - from_ns(activity.since_ns.load());
  };

  const channel::Activity& hooks = channel_.host().hooks;
  if (const std::uint32_t busy = hooks.module.load(std::memory_order_acquire);
      busy != 0 && since(hooks) > kHookLimit) {
    Member& member = *members_.at(busy - 1);
    const Doing doing = hooks.doing.load();
    if (member.pending == doing) {
      host_.ask({.what = host::Request::Do::give_up, .module = member.index});
      lose(member, std::string{channel::to_text(doing)} + " did not return within " + to_text(kHookLimit),
           ErrorType::hang);
    }
  }
  for (auto& member : members_) {
    const channel::Activity& service = member->block.service;
    if (service.module.load(std::memory_order_acquire) == 0 || since(service) <= kHookLimit || member->lost)
      continue;
    host_.ask({.what = host::Request::Do::give_up, .module = member->index});
    lose(*member, "the handler of a service did not return within " + to_text(kHookLimit), ErrorType::hang);
  }
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    const channel::ExecutorBlock& block = channel_.executor(e);
    for (const channel::Activity* activity : {&block.row, &block.sporadic}) {
      const std::uint32_t busy = activity->module.load(std::memory_order_acquire);
      if (busy == 0 || since(*activity) < stuck_after(members_.at(busy - 1)->model)) continue;
      hung_ = {.module = busy - 1,
               .doing = activity->doing.load(),
               .limit = stuck_after(members_[busy - 1]->model)};
      host_.kill();
      return;
    }
  }
}

// The module that keeps a thread of the host, long after all were told to halt.
std::optional<Supervisor::Hang> Supervisor::never_halts() const {
  std::vector<const channel::Activity*> activities;
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    activities.push_back(&channel_.executor(e).row);
    activities.push_back(&channel_.executor(e).sporadic);
  }
  for (const auto& member : members_) activities.push_back(&member->block.background);
  for (const channel::Activity* activity : activities) {
    const std::uint32_t busy = activity->module.load(std::memory_order_acquire);
    if (busy != 0) return Hang{.module = busy - 1, .doing = activity->doing.load(), .limit = kHaltLimit};
  }
  return std::nullopt;
}

void Supervisor::host_ended(const os::ProcessEnd& end) {
  nobody_answers("the host of device " + device().name + " has ended");
  ring(~0U);  // for what it wrote last, if it could not ring for that any more
  for (auto& member : members_) {
    if (member->order && member->is_thread()) end_order(*member, REPLY_FAILED, "the host ended");
  }
  if (phase_ == Phase::ended || (phase_ == Phase::stopping && end_asked_)) return;
  channel::HostBlock& block = channel_.host();
  std::string text = "the host " + end.text();
  Member* culprit = nullptr;
  const ErrorType type = hung_ ? ErrorType::hang : ErrorType::crash;
  if (hung_) {
    culprit = members_[hung_->module].get();
    text = std::string{channel::to_text(hung_->doing)} + " did not return within " + to_text(hung_->limit) +
           ", so the host was ended";
  } else if (block.crash.signal.load() == (end.signalled ? end.code : channel::Crash::kExit) &&
             block.crash.module.load() != 0) {
    culprit = members_.at(block.crash.module.load() - 1).get();
    text += std::string{" in "} + channel::to_text(block.crash.doing.load());
  }
  log(culprit == nullptr ? text : "module " + culprit->model.name + ": " + text);
  hung_.reset();

  // Nobody writes the channel now. What the dead threads were doing is over.
  block.crash.signal.store(0);
  block.crash.module.store(0);
  block.hooks.end();
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    channel::ExecutorBlock& executor = channel_.executor(e);
    executor.row.end();
    executor.sporadic.end();
    executor.row_sequence.store(executor.row_sequence.load() & ~std::uint64_t{1});
  }
  for (auto& member : members_) {
    member->block.background.end();
    member->block.service.end();
    if (member->is_thread()) take_from_tables(*member);
    member->pending.reset();  // nobody will answer
  }

  if (culprit != nullptr) {
    ++culprit->errors;
    lose(*culprit, text, type);
  } else if (phase_ == Phase::preparing) {
    fail_device({"device " + device().name, text, "see what it printed"});
  }
  if (phase_ == Phase::stopping) {
    halted_ = true;
    for (auto& member : members_) {
      if (member->is_thread()) member->lost = true;  // its instance is gone
    }
    return;
  }
  if (culprit == nullptr) {
    const Instant now = os::now();
    std::erase_if(restarts_, [now](Instant then) { return now - then > kRestartWindow; });
    restarts_.push_back(now);
    if (restarts_.size() > kHostRestarts) {
      fail_device({"device " + device().name,
                   text + "; it has been restarted " + std::to_string(kHostRestarts) + " times",
                   "see what it printed"});
      for (auto& member : members_) member->lost |= member->is_thread();
      halted_ = true;
      return;
    }
  }
  if (auto started = start_host(); !started) {
    fail_device(started.problems()[0]);
    return;
  }
  ++host_restarts_;
  log("the host is started again");
  for (auto& member : members_) {
    if (member->is_thread() && !member->lost && member->state() != State::destruct) bring_back(*member);
  }
  if (rows_begun_) host_.ask({.what = host::Request::Do::begin});
  if (background_begun_) host_.ask({.what = host::Request::Do::background});
}

// A module whose instance died with the host, through no fault of its own: loaded afresh.
void Supervisor::bring_back(Member& member) {
  member.pending.reset();
  member.block.error.store(0);
  apply(member, Event::destruct, "its host ended");
  apply(member, Event::reset);
  ask(member, Doing::load);
}

}  // namespace takt::node
