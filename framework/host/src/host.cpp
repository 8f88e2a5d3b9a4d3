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
#include <takt/channel/flight_record.hpp>
#include <takt/channel/module_watch.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/host/protocol.hpp>
#include <takt/host/thread_module.hpp>
#include <takt/model/hosts.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>
#include "executor_threads.hpp"
#include "hook_caller.hpp"
#include "host_links.hpp"
#include "service_thread.hpp"
#include "swap.hpp"
#include "watched_body.hpp"

namespace takt::host {

namespace {

using channel::Doing;

class Host {
 public:
  Host(os::MessageSocket node, channel::Channel channel, channel::FlightRecord record, Setup setup);

  /// Prepares everything except modules: slots, executors, plans.
  Result<void> prepare();
  /// Serves requests until the node asks it to end or is gone.
  void serve();

 private:
  Result<std::string> serve_request(const Request& request);
  Result<void> call(const Request& request);
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
  /// The instance of a module of this host that is in the tables, or will be when it is started.
  ThreadModule& instance(std::uint32_t index) const {
    return *serving_[index].load(std::memory_order_acquire);  // SYNC: serves
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
  std::vector<std::unique_ptr<ThreadModule>> modules_;  // this host's thread modules; null for others
  std::vector<std::atomic<ThreadModule*>>
      serving_;  // the instance in use: that of modules_, or the new one during a trial
  std::vector<std::unique_ptr<WatchedBody>> watched_;  // one for each module, only if a tool watches them
  std::vector<channel::FlightWriter*> records_;  // for each module in the tables, the writer of its executor
  channel::ModuleWatch watch_;
  std::set<std::string> c_form_;  // the loaded files of modules in C form
  std::mutex loading_;
  os::NoDeepIdle no_deep_idle_;
  Result<void> memory_locked_;
  struct Table {
    std::size_t index;  // index among the device's executors
    std::unique_ptr<ExecutorThreads> threads;
  };
  std::vector<Table> executors_;
  std::atomic<bool> halted_{false};  // whether the executors have halted
  std::atomic<std::uint32_t> halt_background_{0};
  std::vector<os::Thread> background_;
  std::vector<std::unique_ptr<ServiceThread>> services_;  // for modules that have handlers
  std::vector<ThreadModule*> handling_;  // the instances that services_ call; changed under exclude()
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
  const auto watch = channel::ModuleWatch::find();
  if (!watch) return watch.problems();
  watch_ = *watch;
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
  watched_.resize(setup_.device.modules.size());
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
    if (watch_ && mine) {
      watched_[i] = std::make_unique<WatchedBody>(*unit.body, i, watch_);
      unit.body = watched_[i].get();
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
    // Executors that spin on the same CPU share the spin time that one of them may take.
    executor.spin_share /= static_cast<double>(
        std::count(setup_.executor_cpus.begin(), setup_.executor_cpus.end(), setup_.executor_cpus[e]));
    executor::Flight flight{&flight_.at(channel::FlightRecord::of_rows(e)),
                            &flight_.at(channel::FlightRecord::of_sporadic(e))};
    executors_.push_back(
        {e, std::make_unique<ExecutorThreads>(executor, mine, select(mine.periodic), select(mine.sporadic),
                                              channel_.executor(e), *wake_word_, flight)});
    for (const std::uint32_t m : mine.periodic) records_[m] = flight.rows;
    for (const std::uint32_t m : mine.sporadic) records_[m] = flight.sporadic;
    if (watch_) executors_.back().threads->watch(watch_, static_cast<std::uint32_t>(e));
  }
  for (std::uint32_t i = 0; i < modules_.size(); ++i) {
    if (modules_[i] && records_[i] != nullptr) modules_[i]->record_to(records_[i], i);
  }
  report_crashes_to(block().crash);
  static_cast<void>(os::pin(0, setup_.background_cpus));
  const auto done = [this](const Request& request, const Result<std::string>& result) {
    ring_pending(*wake_word_);  // wakes the readers of the samples that the hook wrote
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

// Runs on the hook thread, and so do get(), set() and call().
Result<std::string> Host::serve_request(const Request& request) {
  if (request.what == Request::Do::get) return get(request);
  const Result<void> done = request.what == Request::Do::set ? set(request) : call(request);
  if (!done) return done.problems();
  return request.hook == Doing::initialize ? instance(request.module).restored() : std::string{};
}

Result<std::string> Host::get(const Request& request) const {
  const ThreadModule& asked = instance(request.module);
  if (asked.declares_properties()) return asked.get(request.property);
  // A module without declared properties reads those of the descriptor.
  return model::given_property(module(request.module), request.property);
}

Result<void> Host::set(const Request& request) {
  ThreadModule& asked = instance(request.module);
  if (!asked.declares_properties()) {
    return fail(module(request.module).name +
                    " is written in C and declares no properties: it reads them in initialize()",
                "undeploy the cell, change the descriptor and deploy it again");
  }
  // When the module is loaded again, it gets this value, too.
  auto done = asked.set({{request.property, request.value}});
  if (done) model::give_property(setup_.device.modules[request.module], request.property, request.value);
  return done;
}

// A handler never runs at the same time as a hook of its module; the one that is called later waits.
Result<void> Host::call(const Request& request) {
  const auto& service = services_[request.module];
  if (!service) {
    auto done = call_hook(request);
    if (done && request.hook == Doing::load) start_services(request.module);
    return done;
  }
  const auto excluded = service->exclude();
  return call_hook(request);
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
      // global variables, so each further module of the same C file gets its own copy of the globals.
      os::Library::Globals globals = os::Library::Globals::shared;
      {
        const std::lock_guard lock{loading_};
        if (c_form_.count(path) != 0) globals = os::Library::Globals::own;
      }
      auto loaded = called.load(path, globals, sporadic);
      if (loaded && called.component() == nullptr) {
        const std::lock_guard lock{loading_};
        c_form_.insert(path);
      }
      return loaded ? connect(request.module, called) : loaded;
    }
    case Doing::initialize: {
      irp::Property::Values values;
      for (const model::PropertyValue& property : m.properties)
        values.emplace_back(property.name, property.value);
      return called.initialize(irp::Property{std::move(values)});
    }
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
      break;
  }
  return fail("the host does not call this hook on request");
}

// Runs on its own thread, at the same time as hooks of the running instance. A successful swap is answered
// here, before the old instance's destruct(), because the node need not wait for destruct().
Result<std::string> Host::swap(const Request& request) {
  const std::uint32_t index = request.module;
  const model::Module& m = module(index);
  ThreadModule& before = instance(index);
  auto next = make_instance(index);
  next->stand_by();
  next->record_to(records_[index], index);
  next->track_active_in(serving_[index]);
  before.track_active_in(serving_[index]);
  auto watched = watch_ ? std::make_unique<WatchedBody>(*next, index, watch_) : nullptr;
  irp::Property::Values values;
  if (before.declares_properties()) {
    for (const PropertyBase* property : before.properties())
      values.emplace_back(property->name(), *before.get(property->name()));
  } else {
    for (const model::PropertyValue& property : m.properties)
      values.emplace_back(property.name, property.value);
  }
  const auto table = std::find_if(executors_.begin(), executors_.end(), [&](const Table& each) {
    return setup_.device.executors[each.index].name == m.executor;
  });
  executor::Body* const body = watched ? static_cast<executor::Body*>(watched.get()) : next.get();
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
                 .properties = std::move(values),
                 .connect = [this, index, &next] { return connect(index, *next); },
                 .exclude =
                     [this, index] {
                       const auto& service = services_[index];
                       return service ? service->exclude() : std::unique_lock<std::mutex>{};
                     },
                 .handle_by = [this, index](ThreadModule& by) { handling_[index] = &by; },
                 .ends = [this, is_given_up] { return halted_ || is_given_up(); }});
  if (is_given_up()) {  // a hook of the new instance returned too late; its state is unknown
    next->abandon();
    static_cast<void>(next.release());
    return fail("a hook of the new instance did not return in time, so the node abandoned the swap");
  }
  if (!swapped.kept) return fail(swapped.text);
  modules_[index].swap(next);
  watched_[index].swap(watched);
  setup_.paths[index] = request.value;
  answer({.request = request, .ok = true, .text = swapped.text, .warnings = {}});
  block().swap.begin(index, Doing::destruct, to_ns(os::now()));
  static_cast<void>(next->destruct());
  next->unload();
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

// Calls run() of a non-real-time module repeatedly, at its period if it has one.
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
                              to_ns(start));  // must be stored before in_tables is read. SYNC: in tables
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
                          std::memory_order_release);  // SYNC: error raised
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
  // The hook may be waiting for a handler that never returns.
  const bool handler = services_[index] && services_[index]->give_up();
  const bool hook = hooks_->give_up(index);
  if (!handler && !hook) return;
  instance(index).abandon();
  services_[index].reset();
}

// Called when the node is gone. Calls destruct() of all modules and ends, all within a second.
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
    const auto request = decode_request(*text);
    if (!request) {
      std::fprintf(stderr, "takt-host: %s\n", to_text(request.problems()).c_str());
      continue;
    }
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
        // The module's memory stays allocated, because its hook may still use it. A reload makes a new
        // instance.
        give_up(request->module);
        break;
      case Request::Do::give_up_swap:
        ++swaps_given_up_;
        static_cast<void>(swaps_->give_up(request->module));
        break;
      case Request::Do::end:
        // Runs no destructors, because a hook that was given up may still use the objects.
        std::fflush(nullptr);
        std::_Exit(0);
    }
  }
  end_without_node();
  std::_Exit(1);
}

}  // namespace

int run_host() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // so that the output of modules appears line by line
  os::survive_broken_pipes();  // after the node's death, hooks that print must not kill the host
  os::MessageSocket node{os::take_fd_from_environment("TAKT_NODE_FD")};
  os::Fd memory = os::take_fd_from_environment("TAKT_CHANNEL_FD");
  os::Fd record_memory = os::take_fd_from_environment("TAKT_FLIGHT_FD");
  if (!node.fd() || !memory || !record_memory) {
    std::fprintf(stderr, "takt-host: error: only takt-node starts this program; use takt run FILE\n");
    return 2;
  }
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
                 "takt-host: error: the flight record has another number of executors than the channel\n");
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
