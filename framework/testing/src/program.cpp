// Tests a process module that was built as a library: its main() runs on its own stack, and returns control
// to the test when it waits for a release.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string_view>
#include <utility>
#include <vector>

#include <cxxabi.h>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

#include <takt/process.h>
#include <takt/channel/release_slot.hpp>
#include <takt/component/current_cycle.hpp>
#include <takt/component/live_properties.hpp>
#include <takt/component/property.hpp>
#include <takt/component/saved.hpp>
#include <takt/core/check.hpp>
#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/os/fiber.hpp>
#include <takt/os/library.hpp>
#include "subject.hpp"

namespace takt::testing {

/// While this object lives, allocations belong to the program and do not count as memory leaks of the test.
class ProgramAllocations {
 public:
#if defined(__SANITIZE_ADDRESS__)
  ProgramAllocations() { __lsan_disable(); }
  ~ProgramAllocations() { __lsan_enable(); }
#else
  ProgramAllocations() {}
  ~ProgramAllocations() {}
#endif
  ProgramAllocations(const ProgramAllocations&) = delete;
  ProgramAllocations& operator=(const ProgramAllocations&) = delete;
};

using Main = int (*)(int, char**);

/// The C++ library's record of the exceptions that are being handled. Each run of a program has its own
/// record.
class Exceptions {
 public:
  void swap() noexcept {
    void* current = __cxxabiv1::__cxa_get_globals();
    State other;
    std::memcpy(&other, current, sizeof other);
    std::memcpy(current, &state_, sizeof state_);
    state_ = other;
  }

 private:
  struct State {  // with the layout of the C++ ABI
    void* caught = nullptr;
    unsigned uncaught = 0;
  };
  State state_{};
};

/// One run of a program, from main() to its end. At the end of a run, the objects of the program are not
/// destroyed, because a thread of the program may still run. So the program's code and variables stay until
/// the test ends.
class ProgramRun {
 public:
  ProgramRun(std::string path, bool sporadic, channel::ReleaseSlot& slot, VirtualClock& clock)
      : path_(std::move(path)), sporadic_(sporadic), slot_(slot), clock_(clock) {}

  Result<void> load();
  /// Lets the program continue until it calls its init function, waits for a release, or ends.
  void go_on();

  /// Ends the run: the program never continues.
  void crash() { ended_ = true; }

  [[nodiscard]] bool begun() const { return begun_; }
  [[nodiscard]] bool ended() const { return ended_; }
  /// The reason why the run ended, such as "the program called exit(1) before it called initPeriodExe()".
  [[nodiscard]] const std::string& end() const { return end_; }
  /// True if the run ended with status 0.
  [[nodiscard]] bool succeeded() const { return ended_ && status_ == 0; }
  [[nodiscard]] const std::vector<PortBase*>& ports() const { return ports_; }
  /// True if the program has called its init function, and declares properties.
  [[nodiscard]] bool declares_properties() const { return attached_ && !properties_.empty(); }
  [[nodiscard]] LiveProperties& properties() { return live_; }
  std::vector<std::string> arguments;

  // The program calls the following functions.
  void attach(bool sporadic, const char* function);
  void wait(const char* function);
  [[noreturn]] void exit(int status);
  void at_exit(void (*function)()) { at_exit_.push_back(function); }
  /// Ends the program because of wrong use of libtakt_process, as the real library does.
  [[noreturn]] void refuse(const char* function, const char* what);

  static thread_local ProgramRun* running;
  static ProgramRun& of_caller(const char* function);

 private:
  void run_main();
  void give(const std::vector<PropertyBase*>& made);
  void check_properties(const char* function);
  void find_saved(const char* function);
  void restore() const;
  void leave() noexcept;
  [[noreturn]] void finish();
  [[nodiscard]] const char* place() const;

  std::string path_;
  bool sporadic_;
  channel::ReleaseSlot& slot_;
  VirtualClock& clock_;
  os::Library library_;
  Main main_ = nullptr;
  std::vector<PortBase*> ports_;
  std::vector<PropertyBase*> properties_of_file_;
  std::vector<PropertyBase*> properties_;  // all properties, including those that main() constructed
  LiveProperties live_;                    // sets `properties_` while the program runs
  Problems rejected_;                      // values that the properties rejected
  std::vector<SavedBase*> saved_by_;       // the saved variables: global ones, and those that main()
                                           // constructed
  takt_saved_state saved_{};               // the saved variable; data is null if there is none
  std::vector<char*> argv_;
  PortContext context_;
  channel::Taken taken_;
  Cycle cycle_;
  bool begun_ = false;
  bool attached_ = false;
  bool ended_ = false;
  std::string end_;
  int status_ = 1;
  std::vector<void (*)()> at_exit_;
  Exceptions exceptions_;
  os::Fiber test_;
  os::Fiber fiber_{std::size_t{8} << 20, [this] { run_main(); }};
};

thread_local ProgramRun* ProgramRun::running = nullptr;

ProgramRun& ProgramRun::of_caller(const char* function) {
  if (running == nullptr) {
    std::fprintf(
        stderr,
        "%s(): a thread other than that of main() called this function; call it from the thread of main()\n",
        function);
    std::abort();
  }
  return *running;
}

Result<void> ProgramRun::load() {
  static_cast<void>(take_loose_ports());
  static_cast<void>(take_loose_properties());
  static_cast<void>(take_loose_saved());
  const bool copy = LoadedFile::is_taken(path_);
  auto library = os::Library::open(path_, copy ? os::Library::Globals::own : os::Library::Globals::shared);
  if (!library) return library.problems();
  library_ = std::move(*library);
  static std::vector<std::unique_ptr<LoadedFile>> loaded_files;
  loaded_files.push_back(std::make_unique<LoadedFile>());
  loaded_files.back()->take(path_);
  ports_ = take_loose_ports();
  properties_of_file_ = take_loose_properties();
  saved_by_ = take_loose_saved();
  if (const void* of_c = library_.own_symbol("takt_saved"); of_c != nullptr)
    saved_ = *static_cast<const takt_saved_state*>(of_c);
  main_ = reinterpret_cast<Main>(library_.own_symbol("main"));
  library_.abandon();
  if (main_ == nullptr) return fail(path_ + " has no main()", "use a program that takt_add_process() builds");
  return {};
}

void ProgramRun::go_on() {
  TAKT_CHECK(!ended_ && running == nullptr);
  running = this;
  begun_ = true;
  serve_cycle(&cycle_, &slot_.log);
  exceptions_.swap();
  {
    const ProgramAllocations memory;
    test_.hand_over_to(fiber_);
  }
  exceptions_.swap();
  serve_cycle(nullptr);
  running = nullptr;
}

void ProgramRun::leave() noexcept { fiber_.hand_over_to(test_); }

void ProgramRun::run_main() {
  give(properties_of_file_);
  argv_.push_back(path_.data());
  for (std::string& argument : arguments) argv_.push_back(argument.data());
  argv_.push_back(nullptr);
  std::string what;
  try {
    status_ = main_(static_cast<int>(argv_.size()) - 1, argv_.data());
    what = "main() returned " + std::to_string(status_);
  } catch (const std::exception& exception) {
    what = std::string{"main() threw: "} + exception.what();
  } catch (...) {
    what = "main() threw something that is not a std::exception";
  }
  end_ = what + place();
  finish();
}

const char* ProgramRun::place() const {
  if (attached_) return taken_.count == 0 ? " before its first release was served" : "";
  return sporadic_ ? " before it called initSporadicExe()" : " before it called initPeriodExe()";
}

void ProgramRun::finish() {
  while (!at_exit_.empty()) {
    const auto function = at_exit_.back();
    at_exit_.pop_back();
    function();
  }
  std::fflush(nullptr);
  ended_ = true;
  leave();
  std::abort();  // never reached: the program never continues
}

void ProgramRun::exit(int status) {
  status_ = status;
  if (end_.empty()) end_ = "the program called exit(" + std::to_string(status) + ")" + place();
  finish();
}

void ProgramRun::refuse(const char* function, const char* what) {
  end_ = std::string{function} + "(): " + what;
  finish();
}

void ProgramRun::give(const std::vector<PropertyBase*>& made) {
  for (PropertyBase* property : made) {
    properties_.push_back(property);
    const std::string begin = property->name() + "=";
    for (const std::string& argument : arguments) {
      if (!argument.starts_with(begin)) continue;
      if (const auto given = property->assign(argument.substr(begin.size())); !given)
        rejected_.insert(rejected_.end(), given.problems().begin(), given.problems().end());
    }
  }
}

// Checks the properties and arguments as libtakt_process does.
void ProgramRun::check_properties(const char* function) {
  Problems problems = check_declared(properties_, "this program");
  problems.insert(problems.end(), rejected_.begin(), rejected_.end());
  std::vector<std::string_view> names;
  for (const PropertyBase* property : properties_) names.emplace_back(property->name());
  names.emplace_back(kLogLevelProperty);
  for (const std::string& argument : arguments) {
    const std::string_view name = std::string_view{argument}.substr(0, argument.find('='));
    if (!properties_.empty() && std::find(names.begin(), names.end(), name) == names.end())
      problems.push_back(fail("this program has no property " + in_quotes(name), suggestion(name, names)));
  }
  if (!problems.empty()) refuse(function, in_words(problems).c_str());
}

// Finds the saved variable, and checks it as libtakt_process does.
void ProgramRun::find_saved(const char* function) {
  for (SavedBase* one : take_loose_saved()) saved_by_.push_back(one);  // constructed by main()
  if (saved_by_.size() + (saved_.data != nullptr ? 1 : 0) > 1)
    refuse(function, "the program saves more than one variable; put them into one struct");
  if (!saved_by_.empty()) saved_ = {saved_by_[0]->version(), saved_by_[0]->size(), saved_by_[0]->data()};
  if (saved_.size > channel::kMostSaved)
    refuse(function, "the saved variable is too large; use at most 4096 bytes");
}

void ProgramRun::restore() const {
  const channel::SavedState::Copy* before = saved_.data == nullptr ? nullptr : slot_.saved.saved();
  if (before == nullptr) return;
  const bool same = before->version == saved_.version && before->size == saved_.size;
  if (same) std::memcpy(saved_.data, before->bytes.data(), saved_.size);
  for (SavedBase* one : saved_by_) one->set_restored(same);
}

void ProgramRun::attach(bool sporadic, const char* function) {
  if (attached_) refuse(function, "called twice; call it once, before the first wait");
  if (sporadic != sporadic_) {
    refuse(function, sporadic_
                         ? "the test declares the module sporadic; use initSporadicExe() and waitSporadic()"
                         : "the test declares the module periodic; use initPeriodExe() and waitPeriod()");
  }
  attached_ = true;
  give(take_loose_properties());  // properties that main() constructed
  check_properties(function);
  live_.serve(properties_, "this program");
  for (PortBase* port : take_loose_ports()) ports_.push_back(port);  // constructed by main()
  for (const PortBase* port : ports_) {
    for (const PortBase* other : ports_) {
      if (port != other && port->name() == other->name())
        refuse(function, "two ports have the same name; give each a different name");
    }
  }
  context_.start_ns = to_ns(clock_.now());
  for (PortBase* port : ports_) port->serve(context_);
  find_saved(function);
  restore();
  cycle_.period = Nanoseconds{slot_.period_ns};
  slot_.phase = channel::ReleaseSlotPhase::attached;
  leave();
}

// Waits for a release. Uses a release slot like that of takt-node, and writes the same fields of the slot as
// libtakt_process.
void ProgramRun::wait(const char* function) {
  if (!attached_) refuse(function, "call initPeriodExe() or initSporadicExe() first");
  if (std::string_view{function} != (sporadic_ ? "waitSporadic" : "waitPeriod")) {
    refuse(function, sporadic_ ? "the module is sporadic; call waitSporadic()"
                               : "the module is periodic; call waitPeriod()");
  }
  if (const auto late = take_loose_ports(); !late.empty()) {
    const std::string what = "port '" + late.front()->name() +
                             "' was created after this call, so it would have no effect; make it a global "
                             "variable, or create it before this call";
    refuse(sporadic_ ? "initSporadicExe" : "initPeriodExe", what.c_str());
  }
  if (saved_.data != nullptr && taken_.count != 0)
    slot_.saved.save(saved_.data, saved_.size, saved_.version, context_.start_ns);
  slot_.done = taken_.count;
  slot_.phase = channel::ReleaseSlotPhase::ready;
  if (slot_.end != 0) exit(0);
  leave();
  if (slot_.end != 0) exit(0);
  taken_ = channel::take(slot_, taken_.count);
  live_.take_over();
  context_.start_ns = to_ns(clock_.now());
  cycle_.number = taken_.cycle;
  cycle_.time = from_ns(taken_.release_ns);
  cycle_.start = clock_.now();
}

namespace {

/// A process module. Each load() makes a new run of the module's program. A recovery after the end of the
/// program calls load().
class ProgramSubject final : public Subject {
 public:
  ProgramSubject(std::string path, bool sporadic, Nanoseconds period, VirtualClock& clock)
      : path_(std::move(path)), sporadic_(sporadic), period_(period), clock_(clock) {}

  Result<void> load() override {
    static auto& all = *new std::vector<std::unique_ptr<Life>>;  // never destroyed, see ProgramRun
    const auto before = life_ == nullptr ? std::nullopt : life_->slot.saved.copy();
    const std::uint32_t log_level = life_ == nullptr ? 0 : life_->slot.log.level.load();
    all.push_back(std::make_unique<Life>(path_, sporadic_, clock_));
    life_ = all.back().get();
    channel::ReleaseSlot& slot = life_->slot;
    if (before) slot.saved.save(before->bytes.data(), before->size, before->version, before->saved_ns);
    slot.log.level = log_level;
    slot.magic = channel::ReleaseSlot::kMagic;
    slot.kind = sporadic_ ? channel::ReleaseSlotKind::sporadic : channel::ReleaseSlotKind::periodic;
    slot.period_ns = period_.count();
    return life_->run.load();
  }
  Result<void> initialize(const irp::Property& properties) override {
    ProgramRun& run = life_->run;
    for (const auto& [name, value] : properties.values()) run.arguments.push_back(name + "=" + value);
    return go_on();
  }
  Result<void> start() override { return go_on(); }
  Result<void> error(ErrorType) override { return {}; }  // a process module has no hook error()
  Result<void> recover() override { return {}; }
  Result<void> destruct() override {
    life_->slot.end = 1;
    if (life_->run.begun() && !life_->run.ended()) life_->run.go_on();
    return {};
  }
  void crash() override { life_->run.crash(); }
  [[nodiscard]] bool ended() const override { return life_->run.ended(); }
  channel::LogRing& log_ring() override { return life_->slot.log; }

  Result<void> check(const std::string&, const std::string&) override { return {}; }
  Result<void> set(const std::string& name, const std::string& text) override {
    if (ended()) return fail("the program has ended", "set the property after recover()");
    if (!life_->run.declares_properties())
      return fail("the program declares no properties: it gets them as arguments when it starts",
                  "set them before initialize(), or after destruct() and reset()");
    const ProgramAllocations memory;  // the property may be on the program's stack
    return life_->run.properties().set({{name, text}});
  }
  [[nodiscard]] std::optional<Result<std::string>> get(const std::string& name) const override {
    if (ended() || !life_->run.declares_properties()) return std::nullopt;
    return life_->run.properties().get(name);
  }

  [[nodiscard]] const std::vector<PortBase*>& ports() const override { return life_->run.ports(); }
  void connect(PortBase& port, channel::Link link) override {
    const ProgramAllocations memory;  // the port may be on the program's stack
    port.connect(link, nullptr);
  }
  void keep(std::shared_ptr<void> memory) override { life_->kept.push_back(std::move(memory)); }

  void enter(executor::Unit& unit) override { unit.slot = &life_->slot; }
  void serve(channel::ModuleBlock& block) override {
    if (ended() || !life_->slot.in_body()) return;
    life_->run.go_on();
    if (!ended()) return;
    block.in_tables = 0;
    if (life_->run.succeeded()) {
      block.finished = 1;
      return;
    }
    block.errors = block.errors + 1;
    block.error_cycle = life_->slot.cycle(life_->slot.released);
    block.error_text.assign(life_->run.end());
    block.error = static_cast<std::uint32_t>(ErrorType::crash);
  }

 private:
  struct Life {
    Life(const std::string& path, bool sporadic, VirtualClock& clock) : run(path, sporadic, slot, clock) {}
    channel::ReleaseSlot slot{};
    ProgramRun run;
    std::vector<std::shared_ptr<void>> kept;
  };

  // Lets the program continue. The first call runs the program until it has called its init function, and the
  // second call until it waits for a release.
  Result<void> go_on() {
    ProgramRun& run = life_->run;
    run.go_on();
    if (!run.ended()) return {};
    return fail(run.end(), "see the output of the program for the reason");
  }

  std::string path_;
  bool sporadic_;
  Nanoseconds period_;
  VirtualClock& clock_;
  Life* life_ = nullptr;
};

}  // namespace

std::unique_ptr<Subject> make_program_subject(std::string path, bool sporadic, Nanoseconds period,
                                              VirtualClock& clock) {
  return std::make_unique<ProgramSubject>(std::move(path), sporadic, period, clock);
}

}  // namespace takt::testing

using takt::testing::ProgramRun;

extern "C" {

void initPeriodExe(void) { ProgramRun::of_caller("initPeriodExe").attach(false, "initPeriodExe"); }
void initSporadicExe(void) { ProgramRun::of_caller("initSporadicExe").attach(true, "initSporadicExe"); }
void waitPeriod(void) { ProgramRun::of_caller("waitPeriod").wait("waitPeriod"); }
void waitSporadic(void) { ProgramRun::of_caller("waitSporadic").wait("waitSporadic"); }

// The program calls these functions instead of those of the C library, because takt_add_component_test()
// links the program with --wrap.
[[noreturn]] void __wrap_exit(int status);
[[noreturn]] void __wrap_exit(int status) {
  if (ProgramRun::running == nullptr)
    std::exit(status);  // another thread of the program called this function
  ProgramRun::running->exit(status);
}
int __wrap_atexit(void (*function)(void));
int __wrap_atexit(void (*function)(void)) {
  if (ProgramRun::running == nullptr) return std::atexit(function);
  ProgramRun::running->at_exit(function);
  return 0;
}
}
