#include <takt/host/host.hpp>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <set>

#include <takt/channel/channel.hpp>
#include <takt/channel/check_reporter.hpp>
#include <takt/channel/flight_record.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/host/inspect.hpp>
#include <takt/host/protocol.hpp>
#include <takt/host/thread_module.hpp>
#include <takt/model/hosts.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/fork_guard.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/os/signals.hpp>
#include "executor_threads.hpp"
#include "hook_caller.hpp"
#include "host_links.hpp"
#include "reporting_body.hpp"
#include "service_thread.hpp"
#include "swap.hpp"

namespace takt::host {

namespace {

using channel::Doing;

os::Library::Origin origin_of(const Request& request) {
  return request.is_signed ? os::Library::Origin::ignored : os::Library::Origin::searched;
}

class Host {
 public:
  Host(os::MessageSocket node, channel::Channel channel, channel::FlightRecord record, Setup setup);

  /// Attaches the shared memory of the device, and makes the executors and the module instances. Loads no
  /// module.
  Result<void> prepare();
  /// Serves requests until the node asks the host to end, or until the node itself has ended. Then ends the
  /// process.
  void serve();

 private:
  Result<std::string> serve_request(const Request& request);
  Result<void> call(const Request& request);
  Result<void> watched_hook(const Request& request);
  Result<void> call_hook(const Request& request);
  void start_services(std::uint32_t index);
  Result<std::string> get(const Request& request) const;
  Result<void> set(const Request& request);
  Result<std::string> swap(const Request& request);
  Result<void> connect(std::uint32_t index, ThreadModule& instance);
  std::unique_ptr<ThreadModule> make_instance(std::uint32_t index);
  Answer begin();
  void start_background();
  void run_background(std::uint32_t index);
  void halt();
  void give_up(std::uint32_t index);
  void end_without_node();
  void answer(const Answer& answer);
  const model::Module& module(std::uint32_t index) const { return setup_.device.modules[index]; }
  /// Returns the current instance of a module of this host: the one that the executor calls while the module
  /// is in the tables.
  ThreadModule& instance(std::uint32_t index) const {
    return *serving_[index].load(std::memory_order_acquire);  // set by ThreadModule::take_over()
  }
  channel::SavedState& saved_of(std::uint32_t index) const {
    return reinterpret_cast<channel::SavedState*>(saved_memory_.data())[index];
  }
  channel::HostBlock& block() const { return channel_.host(setup_.share); }

  os::MessageSocket node_;
  std::mutex sending_;
  channel::Channel channel_;
  channel::FlightRecord record_;
  std::vector<channel::FlightWriter> flight_;  // one for each ring of the record
  Setup setup_;
  os::SharedMemory wake_word_memory_;
  channel::WakeWord* wake_word_ = nullptr;
  os::SharedMemory saved_memory_;
  std::vector<os::SharedMemory> slot_memories_;
  HostLinks links_;
  model::HostShare share_;
  // By module index; null if the module is not a thread module of this host.
  std::vector<std::unique_ptr<ThreadModule>> modules_;
  // By module index, the instance in use: the one in modules_ or, during the trial of a swap, the new one.
  std::vector<std::atomic<ThreadModule*>> serving_;
  // By module index; null unless libtakt_check watches the host.
  std::vector<std::unique_ptr<ReportingBody>> reporting_;
  // By module index, the flight writer of its executor's thread.
  std::vector<channel::FlightWriter*> records_;
  channel::CheckReporter reporter_;
  std::set<std::string> c_form_;  // the paths of the loaded modules in C form
  std::mutex loading_;
  os::NoDeepIdle no_deep_idle_;
  Result<void> memory_locked_;
  struct Table {
    std::size_t index;  // index among the device's executors
    std::unique_ptr<ExecutorThreads> threads;
  };
  std::vector<Table> executors_;
  std::atomic<bool> halted_{false};  // true once the executors have halted
  std::atomic<std::uint32_t> halt_background_{0};
  std::vector<os::Thread> background_;
  // By module index; null if the module has no handlers.
  std::vector<std::unique_ptr<ServiceThread>> services_;
  // By module index, the instance whose handlers services_ calls. May change only under
  // ServiceThread::exclude().
  std::vector<ThreadModule*> handling_;
  std::unique_ptr<HookCaller> hooks_;
  std::unique_ptr<HookCaller> swaps_;  // carries out swaps, one at a time
  std::atomic<std::uint64_t> swaps_given_up_{0};
};

Host::Host(os::MessageSocket node, channel::Channel channel, channel::FlightRecord record, Setup setup)
    : node_(std::move(node)),
      channel_(std::move(channel)),
      record_(std::move(record)),
      setup_(std::move(setup)),
      share_(model::hosts_of(setup_.device).at(setup_.share)) {
  for (std::size_t ring = 0; ring < record_.rings(); ++ring) flight_.push_back(record_.writer(ring));
}

Result<void> Host::prepare() {
  memory_locked_ = os::lock_memory();  // also locks memory that is mapped later
  const auto reporter = channel::CheckReporter::find();
  if (!reporter) return reporter.problems();
  reporter_ = *reporter;
  auto wake_word = os::SharedMemory::attach(os::Fd{setup_.wake_word_fd});
  if (!wake_word) return wake_word.problems();
  wake_word_memory_ = std::move(*wake_word);
  wake_word_ = reinterpret_cast<channel::WakeWord*>(wake_word_memory_.data());

  auto saved = os::SharedMemory::attach(os::Fd{setup_.saved_fd});
  if (!saved) return saved.problems();
  saved_memory_ = std::move(*saved);
  if (saved_memory_.size() < setup_.device.modules.size() * sizeof(channel::SavedState))
    return fail("the memory for saved state is too small",
                "install takt-node and takt-host of the same version");

  if (auto attached = links_.attach(setup_.links); !attached) return attached;
  std::vector<executor::Unit> units;
  serving_ = std::vector<std::atomic<ThreadModule*>>(setup_.device.modules.size());
  records_.resize(setup_.device.modules.size());
  reporting_.resize(setup_.device.modules.size());
  for (std::uint32_t i = 0; i < setup_.device.modules.size(); ++i) {
    const model::Module& m = module(i);
    executor::Unit unit{.index = i,
                        .block = &channel_.module(i),
                        .period = m.period.value_or(Nanoseconds{0}),
                        .deadline = m.deadline.value_or(Nanoseconds{0}),
                        .budget = m.budget.value_or(Nanoseconds{0}),
                        .interarrival = m.interarrival.value_or(Nanoseconds{0}),
                        .immediate = m.dispatch == model::Dispatch::immediate,
                        .late_is_error = m.miss == model::Miss::error,
                        .overrun = model::contract_of(setup_.device, m),
                        .tolerance = m.tolerance};
    const bool mine = std::find(share_.modules.begin(), share_.modules.end(), i) != share_.modules.end();
    modules_.push_back(mine ? make_instance(i) : nullptr);
    serving_[i] = modules_.back().get();
    if (mine) modules_.back()->save_in(saved_of(i));
    unit.body = modules_.back().get();
    if (reporter_ && mine) {
      reporting_[i] = std::make_unique<ReportingBody>(*unit.body, i, reporter_);
      unit.body = reporting_[i].get();
    }
    if (setup_.slot_fds[i] >= 0) {
      auto memory = os::SharedMemory::attach(os::Fd{setup_.slot_fds[i]});
      if (!memory) return memory.problems();
      unit.slot = reinterpret_cast<channel::ReleaseSlot*>(memory->data());
      slot_memories_.push_back(std::move(*memory));
    }
    units.push_back(unit);
  }

  services_.resize(modules_.size());
  handling_.resize(modules_.size());

  const auto plan = schedule::plan(model::Cell{}, setup_.device);
  if (!plan) return plan.problems();
  const auto select = [&units](const std::vector<std::uint32_t>& indices) {
    std::vector<executor::Unit> selected;
    for (std::uint32_t index : indices) selected.push_back(units[index]);
    return selected;
  };
  for (const std::size_t e : share_.executors) {
    const schedule::ExecutorPlan& mine = plan->executors[e];
    model::Executor executor = setup_.device.executors[e];
    // If several executors spin on the same CPU, they divide the spin time that one executor may use.
    executor.spin_share /= static_cast<double>(
        std::count(setup_.executor_cpus.begin(), setup_.executor_cpus.end(), setup_.executor_cpus[e]));
    executor::Flight flight{&flight_.at(channel::FlightRecord::of_rows(e)),
                            &flight_.at(channel::FlightRecord::of_sporadic(e))};
    executors_.push_back(
        {e, std::make_unique<ExecutorThreads>(executor, mine, select(mine.periodic), select(mine.sporadic),
                                              channel_.executor(e), *wake_word_, flight)});
    for (const std::uint32_t m : mine.periodic) records_[m] = flight.rows;
    for (const std::uint32_t m : mine.sporadic) records_[m] = flight.sporadic;
    if (reporter_) executors_.back().threads->report_to(reporter_, static_cast<std::uint32_t>(e));
  }
  for (std::uint32_t i = 0; i < modules_.size(); ++i) {
    if (modules_[i] && records_[i] != nullptr) modules_[i]->record_to(records_[i], i);
  }
  report_crashes_to(block().crash, reporter_);
  protect_descriptors();
  static_cast<void>(os::pin(0, setup_.background_cpus));
  const auto done = [this](const Request& request, const Result<std::string>& result) {
    ring_pending(*wake_word_);  // wakes the readers of samples that a hook wrote
    answer({.request = request,
            .ok = result.ok(),
            .text = result ? *result : in_words(result.problems()),
            .warnings = {}});
  };
  hooks_ = std::make_unique<HookCaller>(
      block().hooks, setup_.background_cpus,
      [this](const Request& request) { return serve_request(request); }, done);
  swaps_ = std::make_unique<HookCaller>(
      block().swap, setup_.background_cpus, [this](const Request& request) { return swap(request); },
      [done](const Request& request, const Result<std::string>& result) {
        if (!result) done(request, result);
      });
  return {};
}

std::unique_ptr<ThreadModule> Host::make_instance(std::uint32_t index) {
  const model::Module& m = module(index);
  auto made = std::make_unique<ThreadModule>();
  made->attach(wake_word_, &channel_.module(index), model::timing_of(setup_.device, m),
               m.period.value_or(Nanoseconds{0}));
  return made;
}

Result<void> Host::connect(std::uint32_t index, ThreadModule& instance) {
  const std::lock_guard lock{loading_};
  return links_.connect(index, instance);
}

void Host::answer(const Answer& answer) {
  const std::lock_guard lock{sending_};
  node_.send_wait(encode(answer));
}

// Carries out a request. The thread `takt-hooks` calls this function, which calls get(), set() and call().
Result<std::string> Host::serve_request(const Request& request) {
  if (request.what == Request::Do::get) return get(request);
  const Result<void> done = request.what == Request::Do::set ? set(request) : call(request);
  if (!done) return done.problems();
  return request.hook == Doing::initialize ? instance(request.module).restored() : std::string{};
}

Result<std::string> Host::get(const Request& request) const {
  const ThreadModule& asked = instance(request.module);
  if (asked.declares_properties()) return asked.get(request.property);
  // A module that declares no properties reads the values in the descriptor.
  return model::given_property(module(request.module), request.property);
}

Result<void> Host::set(const Request& request) {
  ThreadModule& asked = instance(request.module);
  if (!asked.declares_properties()) {
    return fail(
        "its component is written in C and declares no properties: it reads them, except log-level, in "
        "initialize()",
        "change the descriptor and run takt deploy --update with it, which restarts device " +
            setup_.device.name);
  }
  // The value is also stored in setup_, so that the module gets this value when it is loaded again.
  auto done = asked.set({{request.property, request.value}});
  if (done) model::give_property(setup_.device.modules[request.module], request.property, request.value);
  return done;
}

// Loads a module or calls one of its hooks. A hook waits until a running handler of the same module has
// ended, and a handler waits until a running hook has ended.
Result<void> Host::call(const Request& request) {
  const auto& service = services_[request.module];
  if (!service) {
    auto done = watched_hook(request);
    if (done && request.hook == Doing::load) start_services(request.module);
    return done;
  }
  const auto excluded = service->exclude();
  return watched_hook(request);
}

// Calls a hook. Fails if the hook replaced a handler by which this host reports which module has crashed.
Result<void> Host::watched_hook(const Request& request) {
  auto done = call_hook(request);
  const std::string replaced = os::take_back_crashes();
  if (!done || replaced.empty()) return done;
  return fail("it replaced the signal handler of " + replaced + ", with which the host reports crashes",
              "remove the call of signal() or sigaction() from the module or its libraries");
}

void Host::start_services(std::uint32_t index) {
  handling_[index] = &instance(index);
  if (!handling_[index]->has_handlers()) return;
  channel::ModuleBlock& block = channel_.module(index);
  services_[index] = std::make_unique<ServiceThread>(
      ServiceThread::Options{.index = index,
                             .name = module(index).name + "/serve",
                             .cpus = setup_.background_cpus,
                             .activity = block.service,
                             .wake_word = *wake_word_},
      [this, index] { return handling_[index]->has_request(); },
      [this, index, &block] {
        return handling_[index]->serve(block.in_tables.load(std::memory_order_seq_cst) != 0);
      });
}

Result<void> Host::call_hook(const Request& request) {
  ThreadModule& called = instance(request.module);
  const model::Module& m = module(request.module);
  switch (request.hook) {
    case Doing::load: {
      const std::string& path = setup_.paths[request.module];
      const bool sporadic = m.operation == model::Operation::sporadic;
      // Two modules of one C++ component share only its static variables. A C module keeps its state in
      // global variables, so every module of the same C file, except the first, gets its own copy of the
      // globals.
      os::Library::Globals globals = os::Library::Globals::shared;
      {
        const std::lock_guard lock{loading_};
        if (c_form_.count(path) != 0) globals = os::Library::Globals::own;
      }
      // A copy of its own, because the loader loads the same copy only once.
      auto copy = os::sealed_copy(*request.component, path);
      if (!copy) return copy.problems();
      auto loaded = called.load(path, globals, sporadic, std::move(*copy), origin_of(request));
      if (loaded && called.component() == nullptr) {
        const std::lock_guard lock{loading_};
        c_form_.insert(path);
      }
      return loaded ? connect(request.module, called) : loaded;
    }
    case Doing::initialize:
      return called.initialize(irp::Property{values_of(m)});
    case Doing::start:
      return called.start();
    case Doing::error:
      return called.error(static_cast<ErrorType>(request.error_type));
    case Doing::recover:
      return called.recover();
    case Doing::destruct:
      return called.destruct();
    case Doing::nothing:
    case Doing::run:
    case Doing::condition:
    case Doing::serve:
    case Doing::thread:
      break;
  }
  return fail("the node requested a call that no host makes on request");
}

// Replaces the running instance of a module. Runs on its own thread, at the same time as hooks of the running
// instance. Answers a successful swap before it calls the old instance's destruct(), because the node need
// not wait for destruct().
Result<std::string> Host::swap(const Request& request) {
  const std::uint32_t index = request.module;
  const model::Module& m = module(index);
  ThreadModule& before = instance(index);
  auto next = make_instance(index);
  next->stand_by();
  next->record_to(records_[index], index);
  next->track_active_in(serving_[index]);
  before.track_active_in(serving_[index]);
  auto reporting = reporter_ ? std::make_unique<ReportingBody>(*next, index, reporter_) : nullptr;
  irp::Property::Values values;
  if (!before.declares_properties()) values = values_of(m);
  for (const PropertyBase* property : before.properties()) {
    const auto given = request.values.find(property->name());
    values.emplace_back(property->name(),
                        given == request.values.end() ? *before.get(property->name()) : given->second);
  }
  const auto table = std::find_if(executors_.begin(), executors_.end(), [&](const Table& each) {
    return setup_.device.executors[each.index].name == m.executor;
  });
  executor::Body* const body = reporting ? static_cast<executor::Body*>(reporting.get()) : next.get();
  const std::uint64_t given_up = swaps_given_up_;
  const auto is_given_up = [this, given_up] { return swaps_given_up_ != given_up; };
  const Swapped swapped =
      carry_out({.index = index,
                 .block = channel_.module(index),
                 .before = before,
                 .next = *next,
                 .body = *body,
                 .threads = *table->threads,
                 .place = saved_of(index),
                 .activity = block().swap,
                 .path = request.value,
                 .component = *request.component,
                 .origin = origin_of(request),
                 .properties = std::move(values),
                 .connect = [this, index, &next] { return connect(index, *next); },
                 .exclude =
                     [this, index] {
                       const auto& service = services_[index];
                       return service ? service->exclude() : std::unique_lock<std::mutex>{};
                     },
                 .handle_by = [this, index](ThreadModule& by) { handling_[index] = &by; },
                 .ends = [this, is_given_up] { return halted_ || is_given_up(); }});
  // The hook that did not return in time has returned meanwhile, so the state of `next` is unknown.
  if (is_given_up()) {
    next->abandon();
    static_cast<void>(next.release());
    return fail("a hook of the new instance did not return in time, so the node abandoned the swap");
  }
  if (!swapped.kept) {
    if (!next->unload()) static_cast<void>(next.release());
    return fail(swapped.text);
  }
  modules_[index].swap(next);
  reporting_[index].swap(reporting);
  setup_.paths[index] = request.value;
  answer({.request = request, .ok = true, .text = swapped.text, .warnings = {}});
  block().swap.begin(index, Doing::destruct, to_ns(os::now()));
  static_cast<void>(next->destruct());
  if (!next->unload()) static_cast<void>(next.release());
  return swapped.text;
}

Answer Host::begin() {
  Answer answer{.request = {.what = Request::Do::begin}, .ok = true, .text = {}, .warnings = {}};
  if (!memory_locked_) answer.warnings.push_back(in_words(memory_locked_.problems()));
  const Instant t0 = from_ns(block().t0_ns.load(std::memory_order_acquire));
  for (const Table& table : executors_) {
    Problems denied;
    const auto begun = table.threads->begin(t0, setup_.executor_cpus[table.index], &denied);
    if (!denied.empty()) answer.warnings.push_back(in_words(denied));
    if (begun) continue;
    answer.ok = false;
    answer.text = in_words(begun.problems());
  }
  return answer;
}

void Host::start_background() {
  for (std::uint32_t i = 0; i < modules_.size(); ++i) {
    if (module(i).operation != model::Operation::non_real || !modules_[i]) continue;
    auto thread = os::Thread::start(
        {.name = module(i).name, .cpus = setup_.background_cpus, .stack_bytes = 8 * 1024 * 1024},
        [this, i] { run_background(i); }, nullptr);
    if (thread) background_.push_back(std::move(*thread));
  }
}

// Calls run() of a non-real-time module repeatedly: once in each period, or without a pause if the module has
// no period.
void Host::run_background(std::uint32_t index) {
  static_cast<void>(os::make_background());
  channel::ModuleBlock& block = channel_.module(index);
  report_crashes_as(&block.background);
  const Nanoseconds period = module(index).period.value_or(Nanoseconds{0});
  Cycle cycle{.number = 0, .time = os::now(), .period = period};
  constexpr auto relaxed = std::memory_order_relaxed;
  while (halt_background_.load(relaxed) == 0) {
    const Instant start = os::now();
    block.background.announce(index, Doing::run,
                              to_ns(start));  // before in_tables is read
    if (block.in_tables.load(std::memory_order_seq_cst) != 0) {
      if (period == Nanoseconds{0}) cycle.time = start;
      cycle.start = start;
      const executor::Outcome outcome = instance(index).run(cycle);
      block.jitter.record((cycle.time - start).count());
      block.run.record((os::now() - start).count());
      block.cycles.store(block.cycles.load(relaxed) + 1, relaxed);
      ++cycle.number;
      if (!outcome.ok()) {
        block.in_tables.store(0, std::memory_order_seq_cst);
        block.errors.store(block.errors.load(relaxed) + 1, relaxed);
        block.error_text.assign(outcome.text);
        block.error.store(static_cast<std::uint32_t>(outcome.type),
                          std::memory_order_release);  // after error_text
      } else if (outcome.finished) {
        block.in_tables.store(0, std::memory_order_seq_cst);
        block.finished.store(1, std::memory_order_release);
      }
    }
    ring_pending(*wake_word_);
    block.background.end();
    const bool out = block.in_tables.load(relaxed) == 0;
    const Nanoseconds pause = out ? std::chrono::milliseconds{1} : period;
    if (pause == Nanoseconds{0}) continue;
    cycle.time += pause;
    if (cycle.time < os::now()) cycle.time = os::now();
    if (halt_background_.load(std::memory_order_seq_cst) == 0)
      os::futex_wait(halt_background_, 0, ~0U, cycle.time);
  }
}

void Host::halt() {
  for (const Table& table : executors_) table.threads->ask_to_halt();
  halt_background_.store(1, std::memory_order_seq_cst);
  os::futex_wake(halt_background_, ~0U);
  for (const Table& table : executors_) table.threads->join();
  halted_ = true;
  background_.clear();
}

void Host::give_up(std::uint32_t index) {
  // Give up both threads, because a hook may be waiting for a handler that never returns, or a handler for a
  // hook that never returns.
  auto& service = services_[index];
  const bool handler = service && service->serves();
  const bool hook = hooks_->give_up(index);
  if (!handler && !hook) return;
  instance(index).abandon();
  if (service) service->give_up();
  service.reset();
}

// Called when the node has ended. Calls destruct() of all modules. Ends the process if these calls take
// longer than a second.
void Host::end_without_node() {
  std::atomic<bool> done{false};
  auto watch = os::Thread::start(
      {.name = "takt-farewell"},
      [&done] {
        const Instant limit = os::now() + std::chrono::seconds{1};
        while (!done && os::now() < limit) os::sleep_until(os::now() + std::chrono::milliseconds{10});
        if (!done) std::_Exit(1);
      },
      nullptr);
  for (std::uint32_t i = 0; i < modules_.size(); ++i)
    channel_.module(i).in_tables.store(0, std::memory_order_seq_cst);
  halt();
  for (const auto& instance : modules_) {
    if (!instance || !instance->loaded()) continue;
    const auto& service = services_[static_cast<std::size_t>(&instance - modules_.data())];
    const auto excluded = service ? service->exclude() : std::unique_lock<std::mutex>{};
    static_cast<void>(instance->destruct());
  }
  done = true;
}

void Host::serve() {
  while (auto text = node_.receive_wait()) {
    auto request = decode_request(*text);
    if (!request) {
      std::fprintf(stderr, "takt-host: %s\n", to_text(request.problems()).c_str());
      continue;
    }
    request->component = std::make_shared<os::Fd>(node_.take_file());
    switch (request->what) {
      case Request::Do::call:
      case Request::Do::get:
      case Request::Do::set:
        hooks_->enqueue(*request);
        break;
      case Request::Do::swap:
        swaps_->enqueue(*request);
        break;
      case Request::Do::begin:
        answer(begin());
        break;
      case Request::Do::background:
        start_background();
        break;
      case Request::Do::halt:
        halt();
        answer({.request = *request, .ok = true, .text = {}, .warnings = {}});
        break;
      case Request::Do::give_up:
        // The module's code and objects stay in memory, because the hook may still use them. The next load
        // makes new objects.
        give_up(request->module);
        break;
      case Request::Do::give_up_swap:
        ++swaps_given_up_;
        static_cast<void>(swaps_->give_up(request->module));
        break;
      case Request::Do::end:
        // End without destructors, because a hook that was given up may still use the objects.
        std::fflush(nullptr);
        std::_Exit(0);
    }
  }
  std::fputs("the connection to the node has ended, so this host ends\n", stderr);
  end_without_node();
  std::_Exit(1);
}

}  // namespace

int run_host() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // so that the output of modules appears line by line
  os::survive_broken_pipes();  // a hook that prints after the node has ended must not kill the host
  os::block_user_signals();    // a module may start a timer, and may be unloaded before its signal
  if (const auto guarded = os::guard_against_forks(); !guarded) {
    std::fprintf(stderr, "takt-host: %s\n", to_text(guarded.problems()).c_str());
    return 1;
  }
  os::MessageSocket node{os::take_fd_from_environment("TAKT_NODE_FD")};
  os::Fd memory = os::take_fd_from_environment("TAKT_CHANNEL_FD");
  os::Fd record_memory = os::take_fd_from_environment("TAKT_FLIGHT_FD");
  if (!node.fd() || !memory || !record_memory) {
    std::fprintf(stderr, "takt-host: error: only takt-node starts this program; use takt run FILE\n");
    return 2;
  }
  node.accept_files();
  auto channel = channel::Channel::attach(std::move(memory));
  auto first = node.receive_wait();
  auto record = channel::FlightRecord::attach(std::move(record_memory));
  if (!channel || !record || !first) return 1;
  auto setup = decode_setup(*first);
  if (!setup) {
    std::fprintf(stderr, "takt-host: %s\n", to_text(setup.problems()).c_str());
    return 1;
  }
  if (record->rings() != 2 * channel->executors()) {
    std::fprintf(stderr,
                 "takt-host: error: the flight record and the channel differ in their number of executors; "
                 "install takt-node and takt-host of the same version\n");
    return 1;
  }
  Host host{std::move(node), std::move(*channel), std::move(*record), std::move(*setup)};
  if (const auto prepared = host.prepare(); !prepared) {
    std::fprintf(stderr, "takt-host: %s\n", to_text(prepared.problems()).c_str());
    return 1;
  }
  host.serve();
  return 0;
}

}  // namespace takt::host
