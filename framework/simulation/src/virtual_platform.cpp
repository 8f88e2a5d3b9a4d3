#include "virtual_platform.hpp"

#include <algorithm>

#include "network.hpp"

namespace takt::simulation {

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using supervision::ProcessEnd;

/// The duration of a hook.
constexpr Nanoseconds kHookShortest = microseconds{50};
constexpr Nanoseconds kHookLongest = milliseconds{3};
/// The time from the start of a process module to its first wait for a release.
constexpr Nanoseconds kAttachShortest = milliseconds{2};
constexpr Nanoseconds kAttachLongest = milliseconds{20};
/// The time from the start of a host until it accepts requests.
constexpr Nanoseconds kHostShortest = milliseconds{5};
constexpr Nanoseconds kHostLongest = milliseconds{30};
/// The time from the end of a process until its node notices it.
constexpr Nanoseconds kEndSeenShortest = microseconds{300};
constexpr Nanoseconds kEndSeenLongest = microseconds{5000};
/// The longest time that a process module spins before its release.
constexpr Nanoseconds kMostSpinning = microseconds{100};

const ProcessEnd kKilled{.text = "was killed by SIGKILL (Killed)", .signalled = true, .code = 9};

}  // namespace

// Hosts

Result<void> VirtualHost::start() {
  const bool first = generation_++ == 0;
  alive_ = runs_ = true;
  halting_ = false;
  halt_asked_.reset();
  after_hang_.clear();
  answers_.clear();
  end_.reset();
  free_at_ = device_.now() + (first ? Nanoseconds{0} : device_.draws_.between(kHostShortest, kHostLongest));
  // C++ objects in links between two modules of the shared host were lost when the former process of this
  // host ended. The links of an executor's own host hold bytes, which survive the host.
  const auto has = [this](SimulatedLink::End end) {
    const auto& modules = share().modules;
    return end && std::find(modules.begin(), modules.end(), *end) != modules.end();
  };
  for (auto& link : device_.links_) {
    if (!first && !share().is_own() && has(link->writer()) && has(link->reader())) link->drop();
  }
  rows_.clear();
  for (const std::size_t e : share().executors) {
    rows_.push_back(device_.make_row(static_cast<std::uint32_t>(e), *this, generation_));
    device_.rows_[e] = rows_.back().get();
  }
  for (const std::uint32_t module : share().modules) device_.members_[module]->host = this;
  device_.emit({.what = What::host_began, .host = static_cast<std::uint32_t>(share_)});
  return {};
}

Instant VirtualHost::t0() const { return from_ns(device_.parts_->channel.host(share_).t0_ns.load()); }

// Accepts a request. The host performs its requests one after the other, and each hook takes some time.
bool VirtualHost::ask(const host::Request& request) {
  if (!alive_) return false;
  Nanoseconds takes{};
  const bool is_hook = request.what == host::Request::Do::call || request.what == host::Request::Do::swap;
  if (is_hook && device_.takes_time())
    takes = device_.members_[request.module]->draws.between(kHookShortest, kHookLongest);
  free_at_ = std::max(free_at_, device_.now()) + takes;
  device_.world_.kernel.at(free_at_, [this, request, generation = generation_] {
    if (runs_ && generation == generation_) perform(request);
  });
  return true;
}

void VirtualHost::perform(const host::Request& request) {
  using Do = host::Request::Do;
  switch (request.what) {
    case Do::call:
      return call(request);
    case Do::swap:
      return swap(request);
    case Do::get:
    case Do::set:
      return reply(request);
    case Do::begin:
      begin_rows();
      return reply(request);
    case Do::background:
      return begin_background();
    case Do::halt:
      halt_asked_ = request;
      return halt();
    case Do::end:
      return end({.text = "ended with status 0"});
    case Do::give_up:
      return give_up(request.module);
    case Do::give_up_swap:
      return device_.parts_->channel.host(share_).swap.end();
  }
}

void VirtualHost::call(const host::Request& request) {
  channel::Activity& activity = device_.parts_->channel.host(share_).hooks;
  if (activity.module.load() != 0) return after_hang_.push_back(request);
  Device::Member& member = *device_.members_[request.module];
  const bool mends = request.hook == channel::Doing::recover ||
                     (request.hook == channel::Doing::load &&
                      device_.supervisor_->machine(request.module).state() == lifecycle::State::recover);
  if (mends && member.unmended != 0) {
    --member.unmended;
    return reply(request, false, "injected failure");
  }
  if (meets_fault(request, request.hook, activity)) return;
  if (request.hook == channel::Doing::load) device_.connect(member);
  reply(request);
}

void VirtualHost::swap(const host::Request& request) {
  channel::Activity& activity = device_.parts_->channel.host(share_).swap;
  for (const auto hook : {channel::Doing::load, channel::Doing::initialize, channel::Doing::start}) {
    if (meets_fault(request, hook, activity)) return;
  }
  reply(request);
}

bool VirtualHost::meets_fault(const host::Request& request, channel::Doing hook,
                              channel::Activity& activity) {
  Device::Member& member = *device_.members_[request.module];
  const auto found = std::find_if(member.in_hooks.begin(), member.in_hooks.end(),
                                  [hook](const Injection& injection) { return injection.hook == hook; });
  if (found == member.in_hooks.end()) return false;
  const Injection::Kind kind = found->kind;
  member.in_hooks.erase(found);
  if (kind == Injection::Kind::fail) reply(request, false, "injected failure");
  if (kind == Injection::Kind::crash) end_by_crash(member, hook);
  if (kind == Injection::Kind::hang) activity.begin(member.index, hook, to_ns(device_.now()));
  return true;
}

// Gives up the hook that does not return, and then makes the calls that waited for the end of this hook.
void VirtualHost::give_up(std::uint32_t module) {
  channel::Activity& hooks = device_.parts_->channel.host(share_).hooks;
  if (hooks.module.load() != module + 1) return;
  hooks.end();
  for (const host::Request& request : std::exchange(after_hang_, {})) {
    if (runs_) call(request);
  }
}

void VirtualHost::reply(const host::Request& request, bool ok, std::string text) {
  answers_.push_back({.request = request, .ok = ok, .text = std::move(text), .warnings = {}});
  device_.poke();
}

void VirtualHost::spawn(const Kernel::Scheduling& scheduling, Strand** kept, std::function<void()> body) {
  ++strands_running_;
  Strand& strand = device_.world_.kernel.spawn(scheduling, [this, body = std::move(body)] {
    body();
    if (--strands_running_ == 0 && halt_asked_) halted();
  });
  strands_.push_back(&strand);
  if (kept != nullptr) *kept = &strand;
}

void VirtualHost::begin_rows() {
  if (!std::exchange(device_.began_, true)) device_.emit({.what = What::begins, .release = t0()});
  for (auto& pointer : rows_) {
    Device::Row& row = *pointer;
    if (row.plan.basic_period == Nanoseconds{0}) continue;
    // Executors that name the same CPU share this CPU.
    const std::optional<int> cpu = device_.model().executors[row.index].cpu;
    spawn(device_.scheduling_of(row.index, cpu, row.index, 0), nullptr,
          [this, &row] { device_.walk_rows(row); });
    if (row.plan.sporadic.empty()) continue;
    spawn(device_.scheduling_of(row.index, cpu, row.index, 1), &row.sporadic,
          [this, &row] { device_.serve_sporadic(row); });
  }
}

void VirtualHost::begin_background() {
  for (const std::uint32_t index : share().modules) {
    Device::Member& member = *device_.members_[index];
    if (member.scheduled()) continue;
    spawn({.cpu = nullptr, .priority = 0}, nullptr, [this, &member] { device_.run_background(member); });
  }
}

// Wakes the strands so that they see the halt. A strand that is executing a row completes the row first.
void VirtualHost::halt() {
  halting_ = true;
  for (Strand* strand : strands_) device_.world_.kernel.wake(*strand);
  if (strands_running_ == 0) halted();
}

void VirtualHost::halted() {
  device_.emit({.what = What::halted, .host = static_cast<std::uint32_t>(share_)});
  reply(*halt_asked_);
}

std::optional<host::Answer> VirtualHost::answer() {
  if (answers_.empty()) return std::nullopt;
  host::Answer first = std::move(answers_.front());
  answers_.pop_front();
  return first;
}

std::optional<ProcessEnd> VirtualHost::ended() {
  if (!end_) return std::nullopt;
  alive_ = false;
  return std::exchange(end_, std::nullopt);
}

void VirtualHost::kill() { end(kKilled); }

void VirtualHost::crash(const Device::Member& member) {
  end_by_crash(member, channel::Doing::run);
  device_.world_.kernel.end();
}

void VirtualHost::end_by_crash(const Device::Member& member, channel::Doing doing) {
  constexpr int kSegmentationFault = 11;
  channel::Crash& crash = device_.parts_->channel.host(share_).crash;
  crash.signal.store(kSegmentationFault);
  crash.module.store(member.index + 1);
  crash.doing.store(doing);
  end({.text = "was killed by SIGSEGV (Segmentation fault)", .signalled = true, .code = kSegmentationFault});
}

void VirtualHost::end(ProcessEnd end) {
  if (!runs_) return;
  runs_ = false;
  Kernel& kernel = device_.world_.kernel;
  for (Strand* strand : strands_) {
    if (strand != kernel.running()) kernel.kill(*strand);
  }
  strands_.clear();
  strands_running_ = 0;
  for (auto& row : rows_) {
    row->sporadic = nullptr;
    row->sporadic_on_wake_word = false;
  }
  device_.emit({.what = What::host_ended, .host = static_cast<std::uint32_t>(share_), .text = end.text});
  kernel.at(device_.now() + device_.draws_.between(kEndSeenShortest, kEndSeenLongest), [this, end] {
    end_ = end;
    device_.poke();
  });
}

// Programs

Result<void> VirtualProgram::start() {
  Device::Member& member = this->member();
  member.reported_releases = 0;  // because the start has cleared the module's slot
  if (member.unmended != 0) {
    --member.unmended;
    return fail("injected failure: the program cannot be started");
  }
  alive_ = true;
  end_.reset();
  if (!member.scheduled()) return {};
  const Nanoseconds takes =
      device_.takes_time() ? member.draws.between(kAttachShortest, kAttachLongest) : Nanoseconds{0};
  member.program = &device_.world_.kernel.spawn(device_.scheduling_of(member),
                                                [this, &member, from = device_.now() + takes] {
                                                  device_.world_.kernel.sleep_until(from);
                                                  device_.run_program(member);
                                                });
  return {};
}

std::optional<ProcessEnd> VirtualProgram::ended() {
  if (!end_) return std::nullopt;
  alive_ = false;
  return std::exchange(end_, std::nullopt);
}

void VirtualProgram::terminate() {
  end({.text = "was killed by SIGTERM (Terminated)", .signalled = true, .code = 15});
}

void VirtualProgram::kill() { end(kKilled); }

void VirtualProgram::leave(ProcessEnd end) {
  this->end(std::move(end));
  device_.world_.kernel.end();
}

void VirtualProgram::end(ProcessEnd end) {
  if (!alive_ || (member().scheduled() && member().program == nullptr)) return;
  Kernel& kernel = device_.world_.kernel;
  Strand* const strand = std::exchange(member().program, nullptr);
  member().spins = member().on_wake_word = false;
  if (strand != nullptr && strand != kernel.running()) kernel.kill(*strand);
  kernel.at(device_.now() + device_.draws_.between(kEndSeenShortest, kEndSeenLongest), [this, end] {
    end_ = end;
    device_.poke();
  });
}

// Flows

class VirtualFlows final : public supervision::Flows {
 public:
  explicit VirtualFlows(Device& device) : device_(device) {}

  [[nodiscard]] std::optional<Result<void>> opened() const override { return Result<void>{}; }
  void step(Instant) override {}
  [[nodiscard]] std::optional<wire::FlowHealth> health(std::size_t link) const override {
    if (link >= device_.links_.size()) return std::nullopt;  // this link is for observers
    const std::uint32_t connection = device_.links_[link]->number();
    wire::FlowHealth health;
    health.matched = device_.world_.network->is_cut(connection) ? 0 : 1;
    health.lost = device_.world_.network->lost(connection);
    return health;
  }
  Result<void> tap(std::uint32_t, const std::string&, Instant, Nanoseconds) override {
    return fail("ports of a simulated cell cannot be observed");
  }
  Result<void> open_service(std::uint32_t, const std::string&, Instant) override {
    return fail("services of a simulated cell cannot be called");
  }

 private:
  Device& device_;
};

// The platform

Result<void> VirtualPlatform::begin(supervision::Parts& parts) {
  device_.begin(parts);
  return {};
}

Nanoseconds VirtualPlatform::spin_limit(const model::Module&, Nanoseconds period) const {
  return std::min<Nanoseconds>(period / 10, kMostSpinning);
}

std::unique_ptr<supervision::Host> VirtualPlatform::make_host(std::size_t share) {
  return std::make_unique<VirtualHost>(device_, share);
}

std::unique_ptr<supervision::Program> VirtualPlatform::make_program(std::uint32_t module) {
  auto program = std::make_unique<VirtualProgram>(device_, module);
  device_.members_[module]->process = program.get();
  return program;
}

Result<std::unique_ptr<supervision::Flows>> VirtualPlatform::open_flows() {
  return std::unique_ptr<supervision::Flows>{new VirtualFlows{device_}};
}

void VirtualPlatform::stepped(const supervision::Step& step) {
  // Remove the name of the error, because the event contains the error itself.
  std::string_view text = step.text;
  const std::string prefix = std::string{takt::to_text(step.error)} + ": ";
  if (step.error != ErrorType::none && text.starts_with(prefix)) text.remove_prefix(prefix.size());
  device_.emit({.what = What::step, .error = step.error, .step = step.transition, .text = text},
               *device_.members_[step.module]);
}

void VirtualPlatform::in_tables(std::uint32_t module, bool in) {
  Device::Member& member = *device_.members_[module];
  if (!in && !member.reported_in_tables) return;
  member.reported_in_tables = in;
  device_.emit(in ? What::put_in : What::taken_out, member);
}

void VirtualPlatform::recovering(std::uint32_t module, int attempt) {
  Device::Member& member = *device_.members_[module];
  device_.emit({.what = What::recovery,
                .number = static_cast<std::uint64_t>(attempt),
                .count = static_cast<std::uint64_t>(member.model.recovery.attempts)},
               member);
}

void VirtualPlatform::trace(Nanoseconds, std::size_t, std::function<void(const Result<std::string>&)> done) {
  done(fail("a simulated device keeps no flight record", "use takt simulate --trace to record its events"));
}

}  // namespace takt::simulation
