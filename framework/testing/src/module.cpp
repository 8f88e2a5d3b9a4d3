#include <algorithm>
#include <utility>

#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/executor/executor.hpp>
#include <takt/host/component_path.hpp>
#include <takt/host/log_reader.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/testing.hpp>
#include <takt/testing/tested_file.hpp>
#include "subject.hpp"

namespace takt::testing {

using lifecycle::Event;
using lifecycle::State;

namespace {

std::string& tested_file() {
  static std::string path;
  return path;
}

constexpr std::string_view kProgramSuffix = ".exe.so";

std::string file_of(const Options& options) {
  const std::string& file = options.file.empty() ? tested_file() : options.file;
  if (file.empty())
    throw Error("no component to test; build the test with takt_add_component_test(), or set Options::file");
  if (file.ends_with(".exe"))
    throw Error(file + " is a program and cannot be loaded; use the " + std::string{kProgramSuffix} +
                " that takt_add_component_test() builds from it");
  if (options.period <= Nanoseconds{0})
    throw Error("the period is " + to_text(options.period) + "; it must be positive");
  if (options.file.empty()) return file;
  auto found = host::find_component(file, tested_file());
  if (!found) throw Error(in_words(found.problems()));
  return *found;
}

schedule::ExecutorPlan plan_of(const Options& options) {
  schedule::ExecutorPlan plan;
  plan.basic_period = plan.macro_period = options.period;
  if (options.sporadic) {
    plan.sporadic = {0};
    return plan;
  }
  const schedule::Task task{.period = options.period};
  plan.table = *schedule::Table::build({&task, 1});
  plan.periodic = {0};
  plan.offsets = {Nanoseconds{0}};
  return plan;
}

}  // namespace

detail::TestedFile::TestedFile(const char* path) { tested_file() = path; }

TestLink::TestLink(const TypeInfo& type, std::uint32_t depth, bool is_queue, Nanoseconds deadline)
    : type_(type) {
  const channel::Link::Options options{.depth = depth,
                                       .payload = type.max_size,
                                       .is_queue = is_queue,
                                       .deadline_ns = deadline.count(),
                                       .safe = is_queue ? 0 : type.max_size};
  memory_ = std::make_shared<std::vector<Line>>(channel::Link::layout(options).size() / sizeof(Line) + 1);
  auto* bytes = reinterpret_cast<std::byte*>(memory_->data());
  channel::Link::format(bytes, options);
  link_ = channel::Link{bytes};
  link_.trust();
}

struct Module::Inside {
  explicit Inside(Options o)
      : options(std::move(o)),
        file(file_of(options)),
        is_program(file.ends_with(kProgramSuffix)),
        subject(is_program ? make_program_subject(file, options.sporadic, options.period, clock)
                           : make_thread_subject(file, options.sporadic, options.period, clock, block)) {
    t0 = clock.now();
    if (const auto loaded = subject->load(); !loaded) throw Error(in_words(loaded.problems()));
    make_executor();
  }

  struct Tied {
    std::string port;
    std::unique_ptr<TestLink> link;
    bool stale_is_error = false;
    bool connected = false;
  };

  [[nodiscard]] std::string name() const { return file.substr(file.rfind('/') + 1); }
  void make_executor();
  Result<void> load();
  /// Connects every link whose port the module has already constructed.
  void connect();
  Answer initialize();
  Answer take(Event event);
  /// Takes the module to RECOVER, without calling its hook error().
  Answer leave(ErrorType type, std::string text, std::uint64_t cycle);
  /// Takes the module to RECOVER and calls its hook error().
  Answer fails(ErrorType type, std::string text, std::uint64_t cycle);
  /// Takes the module to DESTRUCT after its last run.
  void finish();
  void put_in(bool in);
  void collect();
  void collect_log();
  [[nodiscard]] PortBase* port(const std::string& name) const;
  [[nodiscard]] std::string ports_in_words() const;

  Options options;
  std::string file;
  bool is_program;
  VirtualClock clock;
  Instant t0{};
  channel::ModuleBlock block{};
  channel::ExecutorBlock executor_block{};
  std::unique_ptr<Subject> subject;
  std::unique_ptr<executor::Executor> executor;
  std::optional<host::LogReader> log_reader;
  channel::LogRing* log_ring = nullptr;  // the ring that the reader reads
  std::vector<Logged> log;
  std::vector<Tied> tied;
  irp::Property::Values values;
  lifecycle::Machine machine;
  Failure failure;
  std::vector<std::pair<std::string, std::unique_ptr<Responder>>> responders;  // the servers, by client name
  std::uint64_t calls = 0;
  std::uint64_t pending_misses = 0;
  bool wanted = false;  // true from start() or recover() until stop(), destruct() or the last run
  bool was_started = false;
};

// Each load of a program makes a new release slot, so the module then needs a new executor.
void Module::Inside::make_executor() {
  executor::Unit unit{.block = &block, .period = options.period};
  subject->enter(unit);
  std::vector<executor::Unit> units{unit};
  executor = options.sporadic
                 ? std::make_unique<executor::Executor>(plan_of(options), std::vector<executor::Unit>{},
                                                        std::move(units), executor_block, clock)
                 : std::make_unique<executor::Executor>(plan_of(options), std::move(units),
                                                        std::vector<executor::Unit>{}, executor_block, clock);
  const Instant next = t0 + options.period * static_cast<std::int64_t>(executor_block.next_row.load());
  executor->join_grid(t0, next);
}

Result<void> Module::Inside::load() {
  for (Tied& tie : tied) tie.connected = false;
  auto loaded = subject->load();
  if (!loaded) return loaded;
  make_executor();
  connect();
  // A C++ component takes each property now; other modules get all properties in initialize().
  for (const auto& [property, text] : values) {
    if (auto set = subject->check(property, text); !set) return set;
  }
  return {};
}

void Module::Inside::connect() {
  for (Tied& tie : tied) {
    PortBase* port = this->port(tie.port);
    if (tie.connected || port == nullptr) continue;
    subject->keep(tie.link->memory_);
    subject->connect(*port, tie.link->link());
    if (port->direction() != PortDirection::out)
      subject->check_deadline(tie.link->link(), *port, tie.stale_is_error);
    tie.connected = true;
  }
}

PortBase* Module::Inside::port(const std::string& name) const {
  const auto& ports = subject->ports();
  const auto found = std::find_if(ports.begin(), ports.end(),
                                  [&name](const PortBase* port) { return port->name() == name; });
  return found == ports.end() ? nullptr : *found;
}

std::string Module::Inside::ports_in_words() const {
  std::string words;
  for (const PortBase* port : subject->ports()) {
    words += (words.empty() ? "it has " : ", ") + std::string{to_text(port->direction())} + " " +
             port->name() + " (" + port->type().name + ")";
  }
  if (!words.empty()) return words;
  return is_program && machine.state() == State::idle
             ? "it has no ports yet; ports that main() constructs exist only after initialize()"
             : "it has no ports";
}

Answer Module::Inside::take(Event event) {
  const auto taken = machine.apply(event);
  if (!taken) return taken.problems();
  return {};
}

void Module::Inside::put_in(bool in) {
  if (in) block.entered = block.entered + 1;
  block.in_tables = in ? 1 : 0;
}

Answer Module::Inside::leave(ErrorType type, std::string text, std::uint64_t cycle) {
  if (!machine.accepts(Event::error)) return take(Event::error);
  put_in(false);
  failure = {.type = type, .text = std::move(text), .cycle = cycle};
  return take(Event::error);
}

Answer Module::Inside::fails(ErrorType type, std::string text, std::uint64_t cycle) {
  if (auto left = leave(type, std::move(text), cycle); !left) return left;
  return subject->error(type);
}

void Module::Inside::finish() {
  put_in(false);
  wanted = false;
  static_cast<void>(take(Event::stop));
  if (const auto done = subject->destruct(); !done)
    failure = {.type = ErrorType::failure, .text = in_words(done.problems()), .cycle = executor->next_row()};
  static_cast<void>(take(Event::destruct));
}

void Module::Inside::collect_log() {
  channel::LogRing& ring = subject->log_ring();
  if (log_ring != &ring) {  // each load of a program makes a new ring
    log_ring = &ring;
    log_reader.emplace(ring);
  }
  while (auto line = log_reader->next(clock.now())) {
    log.push_back({line->level, line->release, std::move(line->text)});
  }
}

void Module::Inside::collect() {
  collect_log();
  for (Tied& tie : tied) tie.link->collect();
  for (const auto& [client, responder] : responders) responder->answer(clock.now());
}

Answer Module::Inside::initialize() {
  if (!machine.accepts(Event::initialize)) return take(Event::initialize);
  if (subject->ended()) {  // the program ended in an earlier call of initialize()
    if (auto loaded = load(); !loaded) return loaded;
  }
  auto done = subject->initialize(irp::Property{values});
  if (!done) return done;
  connect();
  collect();
  return take(Event::initialize);
}

Module::Module(Options options) : inside_(std::make_unique<Inside>(std::move(options))) {}

Module::~Module() {
  const State state = inside_->machine.state();
  if (state != State::idle && state != State::destruct) static_cast<void>(destruct());
}

Answer Module::set(const std::string& property, const std::string& text) {
  Inside& in = *inside_;
  if (property == kLogLevelProperty) {
    const auto level = log_level_from(text);
    if (!level) return level.problems();
    in.subject->log_ring().level = static_cast<std::uint32_t>(*level);
    return {};
  }
  const bool idle = in.machine.state() == State::idle;
  if (in.machine.state() == State::destruct)
    return fail("properties cannot be set in state DESTRUCT", "call reset() first");
  if (auto taken = idle ? in.subject->check(property, text) : in.subject->set(property, text); !taken)
    return taken;
  const auto known = std::find_if(in.values.begin(), in.values.end(),
                                  [&](const auto& value) { return value.first == property; });
  if (known == in.values.end())
    in.values.emplace_back(property, text);
  else
    known->second = text;
  return {};
}

const std::vector<Logged>& Module::log() const {
  inside_->collect_log();
  return inside_->log;
}

bool Module::in_safe_stop() const { return inside_->subject->log_ring().safe_stop != 0; }

Result<std::string> Module::get(const std::string& property) const {
  if (property == kLogLevelProperty)
    return std::string{takt::to_text(static_cast<LogLevel>(inside_->subject->log_ring().threshold()))};
  if (auto got = inside_->subject->get(property)) return std::move(*got);
  for (const auto& [name, text] : inside_->values) {
    if (name == property) return text;
  }
  return fail("property " + in_quotes(property) + " was not set");
}

Answer Module::initialize() { return inside_->initialize(); }

Answer Module::start() {
  Inside& in = *inside_;
  if (in.machine.state() == State::idle) {
    if (auto initialized = in.initialize(); !initialized) return initialized;
  }
  const bool stopped = in.machine.state() == State::start && !in.wanted;
  if (!stopped) {
    if (!in.machine.accepts(Event::start)) return in.take(Event::start);
    auto done = in.subject->start();
    in.collect();
    if (!done) {
      static_cast<void>(in.fails(ErrorType::start, in_words(done.problems()), 0));
      return done;
    }
    if (auto taken = in.take(Event::start); !taken) return taken;
  }
  in.wanted = in.was_started = true;
  in.put_in(true);
  return {};
}

Answer Module::stop() {
  Inside& in = *inside_;
  if (in.machine.state() == State::start && in.wanted) {  // the module has not run since start()
    in.wanted = false;
    in.put_in(false);
    return {};
  }
  if (auto taken = in.take(Event::stop); !taken) return taken;
  in.wanted = false;
  in.put_in(false);
  return {};
}

Answer Module::error(ErrorType type) {
  auto failed = inside_->fails(type, "the test raised this error", inside_->executor->next_row());
  inside_->collect();
  return failed;
}

Answer Module::crash() {
  Inside& in = *inside_;
  auto left = in.leave(ErrorType::crash, "the test raised this error", in.executor->next_row());
  if (left) in.subject->crash();
  return left;
}

Answer Module::recover() {
  Inside& in = *inside_;
  if (!in.machine.accepts(Event::recover)) return in.take(Event::recover);
  Result<void> done;
  if (in.subject->ended()) {
    done = in.load();
    if (done) done = in.subject->initialize(irp::Property{in.values});
    if (done) in.connect();
    if (done) done = in.subject->start();
  } else {
    done = in.subject->recover();
  }
  in.collect();
  if (!done) return done;
  if (auto taken = in.take(Event::recover); !taken) return taken;
  in.wanted = in.was_started = true;
  in.put_in(true);
  return {};
}

Answer Module::destruct() {
  Inside& in = *inside_;
  if (!in.machine.accepts(Event::destruct)) return in.take(Event::destruct);
  in.put_in(false);
  in.wanted = false;
  auto done = in.subject->destruct();
  in.collect();
  if (auto taken = in.take(Event::destruct); !taken) return taken;
  return done;
}

Answer Module::reset() {
  Inside& in = *inside_;
  if (!in.machine.accepts(Event::reset)) return in.take(Event::reset);
  in.subject->forget();
  if (auto loaded = in.load(); !loaded) return loaded;
  in.failure = {};
  in.was_started = false;
  return in.take(Event::reset);
}

State Module::state() const { return inside_->machine.state(); }

std::uint64_t Module::step(std::uint64_t releases) {
  Inside& in = *inside_;
  if (!in.was_started && (state() == State::idle || state() == State::initialize))
    throw Error("step() is not allowed in state " + std::string{lifecycle::to_text(state())} +
                "; call start() first");
  for (Inside::Tied& tie : in.tied) tie.link->begin_step();
  const std::uint64_t before = runs();
  for (; releases > 0; --releases) {
    in.clock.go_to(next_release());
    in.pending_misses = 0;
    const std::uint64_t ran = runs();
    in.executor->run_cycle(in.clock.now());
    while (in.executor->run_sporadic()) {
    }
    in.subject->serve(in.block);
    in.collect();
    if (runs() != ran && state() == State::start) static_cast<void>(in.take(Event::run));
    const auto type = static_cast<ErrorType>(in.block.error.exchange(0));
    if (type != ErrorType::none) {
      static_cast<void>(in.fails(type, std::string{in.block.error_text.view()}, in.block.error_cycle));
      in.collect();
    }
    if (in.block.finished.exchange(0) != 0) {
      in.finish();
      in.collect();
    }
  }
  return runs() - before;
}

void Module::miss(std::uint64_t releases) { inside_->pending_misses += releases; }

Instant Module::next_release() const {
  return inside_->executor->next_release() +
         inside_->options.period * static_cast<std::int64_t>(inside_->pending_misses);
}

std::uint64_t Module::runs() const { return inside_->block.cycles; }
std::uint64_t Module::missed() const { return inside_->block.missed; }
const Failure& Module::last_error() const { return inside_->failure; }

Answer Module::healthy() const {
  if (state() != State::recover) return {};
  const Failure& failure = inside_->failure;
  return fail("the module has been in RECOVER since release " + std::to_string(failure.cycle) + ": " +
              to_text(failure.type) + ": " + failure.text);
}

std::uint32_t Module::most_of_a_run(const TypeInfo& type) {
  constexpr std::uint32_t kBytes = 4 << 20;
  return std::clamp(kBytes / type.max_size, 16U, 1024U);
}

Module::Tie Module::find(const std::string& port, Side side, const TypeInfo& type,
                         const Connection* wanted) const {
  const Inside& in = *inside_;
  const PortBase* found = in.port(port);
  if (found == nullptr)
    throw Error(in.name() + " has no port " + in_quotes(port) + "; " + in.ports_in_words());
  const bool is_out = found->direction() == PortDirection::out;
  if (is_out != (side == Side::out)) {
    throw Error("port " + in_quotes(port) + " of " + in.name() + " is an " + (is_out ? "output" : "input") +
                "; use " + (is_out ? "out" : "in") + "<" + found->type().name + ">()");
  }
  if (std::string_view{type.description} != found->type().description) {
    const bool renamed = std::string_view{type.name} != found->type().name;
    throw Error(
        "port " + in_quotes(port) + " of " + in.name() + " has the type " + found->type().name +
        (renamed ? ", not " + std::string{type.name} : ", but from another IDL file than the test's"));
  }
  if (wanted != nullptr && wanted->deadline != Nanoseconds{0} && in.is_program)
    throw Error(
        "the harness does not check the deadlines of a program's inputs; use error(ErrorType::stale)");
  if (wanted != nullptr && wanted->stale_is_error && wanted->deadline == Nanoseconds{0})
    throw Error("without a deadline no value is stale; give the connection of " + in_quotes(port) +
                " a deadline");
  const auto tied = std::find_if(in.tied.begin(), in.tied.end(),
                                 [&port](const Inside::Tied& tie) { return tie.port == port; });
  if (tied != in.tied.end()) {
    if (wanted != nullptr)
      throw Error("port " + in_quotes(port) +
                  " is connected already; pass the connection in the first call of in() for the port");
    return {.link = tied->link.get()};
  }
  if (wanted == nullptr) return {};
  const std::uint32_t queue = wanted->queue;
  return {.queue = queue == 0 && found->direction() == PortDirection::event ? 64 : queue};
}

void Module::find_service(const std::string& name, bool is_client, const TypeInfo& request,
                          const TypeInfo& reply) const {
  const Inside& in = *inside_;
  // The type names of a service's two ports are NAME_Request and NAME_Reply.
  const auto type_of = [&in](const std::string& service, const char* half) {
    const PortBase* port = in.port(service + half);
    const std::string type = port == nullptr ? "" : port->type().name;
    return type.substr(0, type.rfind('_'));
  };
  const auto spelled = [](bool client, const std::string& service, const std::string& from,
                          const std::string& to) {
    return std::string{client ? "client " : "service "} + service + " (" + from + " -> " + to + ")";
  };
  std::string all;
  for (const PortBase* port : in.subject->ports()) {
    if (port->role() == PortRole::plain || !port->name().ends_with(kRequestPort)) continue;
    const std::string other =
        port->name().substr(0, port->name().size() - std::string_view{kRequestPort}.size());
    const bool client = port->role() == PortRole::client;
    const std::string from = type_of(other, kRequestPort);
    const std::string to = type_of(other, kReplyPort);
    if (other == name && client == is_client && from == request.name && to == reply.name) return;
    all += (all.empty() ? "" : ", ") + spelled(client, other, from, to);
  }
  throw Error(in.name() + " has no " + spelled(is_client, name, request.name, reply.name) + "; it has " +
              (all.empty() ? "none" : all));
}

void Module::respond(const std::string& client, std::unique_ptr<Responder> responder) {
  for (const auto& [name, other] : inside_->responders) {
    if (name == client)
      throw Error("client " + in_quotes(client) + " has a server already; call serve() once");
  }
  inside_->responders.emplace_back(client, std::move(responder));
}

std::uint64_t Module::call_number() { return ++inside_->calls; }

void Module::tie(const std::string& port, std::unique_ptr<TestLink> link, const Connection& connection) {
  inside_->tied.push_back({.port = port,
                           .link = std::move(link),
                           .stale_is_error = connection.stale_is_error,
                           .connected = false});
  inside_->connect();
}

}  // namespace takt::testing
