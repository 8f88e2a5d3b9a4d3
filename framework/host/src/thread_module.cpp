#include <takt/host/thread_module.hpp>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <utility>

#include <takt/component/current_cycle.hpp>
#include <takt/component/failure.hpp>
#include <takt/core/words.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/fork_guard.hpp>
#include "executor_threads.hpp"
#include "own_threads.hpp"

namespace takt::host {

namespace {

/// Exists during a call of a hook other than run() and condition(). Samples that the hook writes get the time
/// of the call as their stamp, because these hooks have no release.
class InHook {
 public:
  InHook(Instant now, Nanoseconds period, channel::LogRing* log) noexcept
      : cycle_{.number = 0, .time = {}, .period = period, .start = now} {
    serve_cycle(&cycle_, log);
  }
  ~InHook() { serve_cycle(nullptr); }
  InHook(const InHook&) = delete;
  InHook& operator=(const InHook&) = delete;

 private:
  Cycle cycle_;
};

/// Returns the problem that a component has a `what`, such as a port, with an invalid name.
Problem wrong_name(const std::string& path, const std::string& what, const std::string& name) {
  return fail(path + " has a " + what + " with the invalid name " + in_quotes(name), model::kNameRule);
}

}  // namespace

Instant ThreadModule::now() const noexcept { return clock_ == nullptr ? os::now() : clock_->now(); }

// Calls a hook, which is foreign code. Converts an exception or a takt_fail() in the hook into a failure.
template <class Call>
Result<void> ThreadModule::guarded(Call&& call) {
  static_cast<void>(take_failure());
  const InHook in_hook{now(), period_, log_ring()};
  const InInstance in_instance{own_threads_};
  try {
    Result<void> result = std::forward<Call>(call)();
    os::end_forked_copy();
    if (!result) return result;
  } catch (const ThreadExit& exit) {
    return fail(exit.what());
  } catch (const std::exception& exception) {
    return fail(std::string{"threw: "} + exception.what());
  } catch (...) {
    return fail("threw something that is not a std::exception");
  }
  if (const char* text = take_failure(); text != nullptr) return fail(text);
  return {};
}

template <class Function, class... Arguments>
Result<void> ThreadModule::call(Function function, Arguments&&... arguments) {
  return guarded([&]() -> Result<void> {
    if (function != nullptr) function(std::forward<Arguments>(arguments)...);
    return {};
  });
}

ThreadModule::~ThreadModule() { unload(); }

Result<void> ThreadModule::load(const std::string& path, os::Library::Globals globals, bool sporadic,
                                os::Fd copy, os::Library::Origin origin) {
  unload();
  static_cast<void>(take_loose_ports());
  static_cast<void>(take_loose_properties());
  static_cast<void>(take_loose_saved());
  const InInstance in_instance{own_threads_};
  auto library = os::Library::open(path, globals, std::move(copy), origin);
  if (!library) return library.problems();
  library_ = std::move(*library);
  ports_ = take_loose_ports();  // the global ports, which os::Library::open() has just constructed
  properties_ = take_loose_properties();

  if (void* get_factory = library_.own_symbol("takt_component_factory"); get_factory != nullptr) {
    factory_ = reinterpret_cast<const ComponentFactory* (*)()>(get_factory)();
    if (factory_ == nullptr || factory_->abi != ComponentFactory::kAbi ||
        factory_->component_size != sizeof(Component)) {
      unload();
      return fail(path + " was compiled against another version of Takt", "compile it again");
    }
    auto created = guarded([this]() -> Result<void> {
      const ConstructingComponent constructing;
      component_ = factory_->create();
      return {};
    });
    if (!created) {
      created = fail("the constructor of " + std::string{factory_->name} + " in " + path + " " +
                         created.problems()[0].what,
                     "a constructor only declares ports and properties; work that can fail belongs in "
                     "initialize()");
    }
    if (created) created = take_ports(path);
    if (created) created = take_properties(path);
    if (created) created = take_saved(path);
    if (!created) unload();
    if (created && sporadic && !may_be_ready()) {
      unload();
      return fail(path + " has neither condition() nor an event port, so it would never run",
                  "override condition(), give it an EventPort, or make the module periodic");
    }
    return created;
  }

  const auto find = [this](auto& hook, const char* name) {
    hook = reinterpret_cast<std::remove_reference_t<decltype(hook)>>(library_.own_symbol(name));
  };
  // The file may define `void initialize(void)` (Figure 10 of the paper). With the C calling convention of
  // Linux, the extra argument does no harm.
  find(initialize_, "initialize");
  find(start_, "start");
  find(run_, "run");
  find(condition_, "condition");
  find(error_, "error");
  find(recover_, "recover");
  find(destruct_, "destruct");
  if (run_ == nullptr) {
    unload();
    return fail(path + " has no function run()",
                R"(define extern "C" void run(void), or a class with TAKT_COMPONENT)");
  }
  if (sporadic && !may_be_ready()) {
    unload();
    return fail(path + " has neither a function condition() nor an event port, so it would never run",
                R"(define extern "C" int condition(), or make the module periodic)");
  }
  auto taken = take_ports(path);
  if (taken) taken = take_properties(path);
  if (taken) taken = take_saved(path);
  if (!taken) unload();
  return taken;
}

Result<void> ThreadModule::take_properties(const std::string& path) {
  if (component_ != nullptr) {
    if (!properties_.empty()) {
      return fail(path + " has the property '" + properties_.front()->name() + "' outside its component",
                  "make it a member: Property<T> name{*this, \"name\", ...}");
    }
    properties_ = component_->properties();
  }
  for (const PropertyBase* property : properties_) {
    if (!model::is_valid_name(property->name())) return wrong_name(path, "property", property->name());
  }
  if (Problems problems = check_declared(properties_, path); !problems.empty()) return problems;
  live_.serve(properties_, "component " + (component_ != nullptr ? factory_->name : model::file_stem(path)));
  return {};
}

Result<void> ThreadModule::take_saved(const std::string& path) {
  if (const auto outside = take_loose_saved(); !outside.empty())
    return fail(path + " has a Saved<T> variable outside a component",
                component_ != nullptr
                    ? "make it a member: Saved<T> name{*this, 1}"
                    : "in a module with C functions, declare the variable with TAKT_SAVED(1, "
                      "variable) from <takt/saved.h>");
  if (component_ != nullptr) {
    const auto& saved = component_->saved();
    if (saved.size() > 1)
      return fail(path + " has " + std::to_string(saved.size()) + " Saved members",
                  "put them into one struct");
    if (!saved.empty()) saved_ = {saved[0]->version(), saved[0]->size(), saved[0]->data()};
  } else if (const void* own = library_.own_symbol("takt_saved"); own != nullptr) {
    saved_ = *static_cast<const takt_saved_state*>(own);
    if (saved_.data == nullptr || saved_.size == 0 || saved_.size > channel::kMostSaved) {
      saved_ = {};
      return fail(path + " saves a variable that is too large",
                  "save at most " + std::to_string(channel::kMostSaved) + " bytes");
    }
  }
  return {};
}

// Restores the state that the module's former instance saved. If the version or size differs, only the
// component itself understands the saved state. So the component's restore() translates it.
void ThreadModule::restore() {
  restored_.clear();
  channel::SavedState* const place = place_.load(std::memory_order_relaxed);
  if (saved_.data == nullptr || place == nullptr) return;
  const channel::SavedState::Copy* before = place->saved();
  if (before == nullptr) return;
  Result<void> restored;
  if (before->version == saved_.version && before->size == saved_.size) {
    std::memcpy(saved_.data, before->bytes.data(), saved_.size);
    restored_ = "its saved state was restored";
  } else if (component_ != nullptr) {
    restored = guarded([&] {
      return component_->restore({before->version, before->bytes.data(), before->size});
    });
    restored_ = "restore() converted the state that version " + std::to_string(before->version) + " saved";
  } else {
    restored = fail("it was saved by version " + std::to_string(before->version) + ", " +
                    std::to_string(before->size) + " bytes");
  }
  if (!restored) restored_ = "its saved state was not restored: " + in_words(restored.problems());
  if (component_ != nullptr) component_->saved()[0]->set_restored(restored.ok());
}

void ThreadModule::save() noexcept {
  channel::SavedState* const place = place_.load(std::memory_order_relaxed);
  if (saved_.data == nullptr || place == nullptr) return;
  place->save(saved_.data, saved_.size, saved_.version, context_.start_ns);
}

Result<void> ThreadModule::match(const ThreadModule& before) {
  std::string differences;
  const auto differs = [&differences](const std::string& what) {
    differences += (differences.empty() ? "" : ", ") + what;
  };
  if ((component_ == nullptr) != (before.component_ == nullptr))
    differs(component_ == nullptr
                ? "the new instance is written in C, but the running one is a takt::Component"
                : "the new instance is a takt::Component, but the running one is written in C");
  std::vector<PortBase*> ports;
  for (const PortBase* old : before.ports_) {
    PortBase* mine = port(old->name());
    const std::string name = "port " + in_quotes(old->name());
    if (mine == nullptr) {
      differs(name + " is missing");
      continue;
    }
    ports.push_back(mine);
    const auto kind = [](const PortBase& one) {
      return std::string{to_text(one.direction())} + (one.role() == PortRole::plain ? "" : " of a ") +
             (one.role() == PortRole::plain ? "" : to_text(one.role()));
    };
    if (kind(*mine) != kind(*old)) differs(name + " is " + kind(*mine) + ", not " + kind(*old));
    if (std::string_view{mine->type().name} != old->type().name)
      differs(name + " is of type " + mine->type().name + ", not " + old->type().name);
    else if (std::string_view{mine->type().description} != old->type().description)
      differs(name + " has another definition of type " + mine->type().name);
  }
  for (const PortBase* mine : ports_)
    if (before.port(mine->name()) == nullptr) differs("port " + in_quotes(mine->name()) + " is new");
  const auto property = [](const ThreadModule& of, const std::string& name) -> const PropertyBase* {
    const auto found = std::find_if(of.properties_.begin(), of.properties_.end(),
                                    [&name](const PropertyBase* each) { return each->name() == name; });
    return found == of.properties_.end() ? nullptr : *found;
  };
  for (const PropertyBase* old : before.properties_) {
    const PropertyBase* mine = property(*this, old->name());
    const std::string name = "property " + in_quotes(old->name());
    if (mine == nullptr)
      differs(name + " is missing");
    else if (mine->type() != old->type())
      differs(name + " is of type " + to_text(mine->type()) + ", not " + to_text(old->type()));
  }
  for (const PropertyBase* mine : properties_)
    if (property(before, mine->name()) == nullptr) differs("property " + in_quotes(mine->name()) + " is new");
  if (!differences.empty()) {
    return fail("it differs from the running module: " + differences,
                "name this file in the descriptor and run takt deploy --update, which restarts the device");
  }
  ports_ = std::move(ports);
  serve_ports();
  return {};
}

Result<void> ThreadModule::follow(const ThreadModule& before) {
  translated_.reset();
  if (saved_.data == nullptr || before.saved_.data == nullptr) return {};
  const auto state = before.place_.load(std::memory_order_relaxed)->copy();
  const bool same = saved_.version == before.saved_.version && saved_.size == before.saved_.size;
  if (!same) translated_ = state ? state->number : 0;
  if (!state) return {};
  if (same) {
    std::memcpy(saved_.data, state->bytes.data(), saved_.size);
  } else {
    const std::string theirs = "the state that version " + std::to_string(state->version) + " saved";
    if (component_ == nullptr)
      return fail("its saved variable differs in size or version from " + theirs,
                  "save the same variable, or write the module as a takt::Component with restore()");
    const auto restored = guarded([&] {
      return component_->restore({state->version, state->bytes.data(), state->size});
    });
    if (!restored) return fail("it cannot take over " + theirs + ": " + in_words(restored.problems()));
  }
  if (component_ != nullptr) component_->saved()[0]->set_restored(true);
  return {};
}

bool ThreadModule::take_over(executor::Body& body) noexcept {
  auto& before = static_cast<ThreadModule&>(body);
  if (stands_by_) {  // false if the executor puts this instance back, which then keeps its own state
    if (translated_) {
      const auto& place = *before.place_.load(std::memory_order_relaxed);
      if (place.whole.load(std::memory_order_relaxed) != *translated_) return false;
    } else if (saved_.data != nullptr && before.saved_.data != nullptr) {
      std::memcpy(saved_.data, before.saved_.data, saved_.size);
    }
    stands_by_ = false;
  }
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (ports_[i]->role() != PortRole::handler) ports_[i]->take_over(*before.ports_[i]);
  }
  for (std::size_t i = 0; i < watched_.size(); ++i) watched_[i].late = before.watched_[i].late;
  entered_ = before.entered_;
  watched_since_ns_ = before.watched_since_ns_;
  if (active_ != nullptr) active_->store(this, std::memory_order_release);  // read by Host::instance()
  return true;
}

void ThreadModule::take_over_handlers(ThreadModule& before) noexcept {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (ports_[i]->role() == PortRole::handler) ports_[i]->take_over(*before.ports_[i]);
  }
}

Result<void> ThreadModule::take_ports(const std::string& path) {
  if (component_ != nullptr) {
    if (!ports_.empty()) {
      return fail(path + " has the port '" + ports_.front()->name() + "' outside its component",
                  "make it a member: InPort<T> name{*this, \"name\"}");
    }
    ports_ = component_->ports();
  }
  for (auto port = ports_.begin(); port != ports_.end(); ++port) {
    const bool plain = (*port)->role() == PortRole::plain;
    // Returns the port's name; for a port of a service NAME (NAME/request or NAME/reply), returns NAME.
    const auto name_of = [](const PortBase& one) {
      return one.role() == PortRole::plain ? one.name() : one.name().substr(0, one.name().rfind('/'));
    };
    const std::string name = name_of(**port);
    if (!model::is_valid_name(name)) {
      return wrong_name(path, to_text((*port)->role()), name);
    }
    if (!plain && name.size() > model::kMaxServiceName) {
      return fail(path + " has a service or client whose name is too long: " + in_quotes(name),
                  "use at most " + std::to_string(model::kMaxServiceName) + " characters");
    }
    const auto clash = std::find_if(ports_.begin(), port, [&](const PortBase* other) {
      return name_of(*other) == name &&
             (plain || other->role() == PortRole::plain || other->name() == (*port)->name());
    });
    if (clash != port) {
      return fail(path + " has two ports '" + name + "'" + (plain ? "" : ", one of a service or client"),
                  "give each a different name");
    }
  }
  serve_ports();
  return {};
}

void ThreadModule::serve_ports() {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    ports_[i]->serve(ports_[i]->role() == PortRole::handler ? handler_context_ : context_,
                     static_cast<std::uint32_t>(i));
    if (stands_by_) ports_[i]->stand_by();
  }
}

bool ThreadModule::may_be_ready() const noexcept {
  if (component_ != nullptr ? factory_->own_condition : condition_ != nullptr) return true;
  return std::any_of(ports_.begin(), ports_.end(),
                     [](const PortBase* port) { return port->direction() == PortDirection::event; });
}

PortBase* ThreadModule::port(const std::string& name) const noexcept {
  const auto found = std::find_if(ports_.begin(), ports_.end(),
                                  [&name](const PortBase* port) { return port->name() == name; });
  return found == ports_.end() ? nullptr : *found;
}

void ThreadModule::check_deadline(channel::Link link, const PortBase& input, bool stale_is_error) {
  const Nanoseconds deadline{link.block().deadline_ns};
  if (deadline <= Nanoseconds{0}) return;
  watched_.push_back({link, stale_is_error,
                      "the newest value of input '" + input.name() + "' is older than " + to_text(deadline),
                      false});
}

const char* ThreadModule::check_inputs(Instant start) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  const std::int64_t now = to_ns(start);
  const std::uint64_t entered = block_ == nullptr ? 1 : block_->entered.load(relaxed);
  if (entered != entered_) {
    entered_ = entered;
    watched_since_ns_ = now;
  }
  const char* stale = nullptr;
  for (Watched& input : watched_) {
    channel::LinkBlock& block = input.link.block();
    const std::int64_t newest = std::max(block.newest_ns.load(relaxed), watched_since_ns_);
    const bool late = now - newest > block.deadline_ns && !input.link.is_forced(now);
    if (late && !input.late) block.late.store(block.late.load(relaxed) + 1, relaxed);
    input.late = late;
    if (late && input.is_error && stale == nullptr) stale = input.text.c_str();
  }
  return stale;
}

void ThreadModule::begin_hook() noexcept {
  context_.start_ns = to_ns(now());
  context_.valid_ns = 0;
  live_.take_over();
}

bool ThreadModule::unload() {
  ports_.clear();
  watched_.clear();
  live_.serve({}, {});
  properties_.clear();
  saved_ = {};
  if (component_ != nullptr) factory_->destroy(component_);
  const std::string name{block_ != nullptr ? block_->name.view() : ""};
  stop_timers(own_threads_);
  const bool still_used = own_threads_.use_count() > 1;
  if (still_used) {
    std::fprintf(stderr,
                 "module %s: a thread that it started still runs, so its code stays in memory; end the "
                 "module's threads in destruct()\n",
                 name.c_str());
    library_.abandon();
  }
  component_ = nullptr;
  factory_ = nullptr;
  initialize_ = nullptr;
  start_ = run_ = recover_ = destruct_ = nullptr;
  condition_ = nullptr;
  error_ = nullptr;
  library_ = {};  // may delete timers, too
  if (delete_timers(own_threads_)) {
    std::fprintf(stderr,
                 "module %s: the host has deleted a timer that the module left running (timer_create() with "
                 "SIGEV_THREAD); delete the module's timers in destruct()\n",
                 name.c_str());
  }
  if (still_used) own_threads_ = std::make_shared<const char>();
  return !still_used;
}

void ThreadModule::abandon() noexcept {
  ports_.clear();
  watched_.clear();
  live_.serve({}, {});
  properties_.clear();
  saved_ = {};
  component_ = nullptr;
  library_.abandon();
}

Result<void> ThreadModule::initialize(const irp::Property& property) {
  if (declares_properties()) {
    if (auto taken = set(property.values()); !taken) return taken;
  }
  begin_hook();
  auto initialized = component_ != nullptr ? guarded([this] { return component_->initialize(); })
                                           : call(initialize_, property);
  if (initialized) restore();
  return initialized;
}

Result<void> ThreadModule::start() {
  begin_hook();
  return component_ != nullptr ? guarded([this] { return component_->start(); }) : call(start_);
}

Result<void> ThreadModule::error(ErrorType type) {
  begin_hook();
  if (component_ == nullptr) return call(error_, static_cast<int>(type));
  return guarded([this, type]() -> Result<void> {
    component_->error(type);
    return {};
  });
}

Result<void> ThreadModule::recover() {
  begin_hook();
  return component_ != nullptr ? guarded([this] { return component_->recover(); }) : call(recover_);
}

Result<void> ThreadModule::destruct() {
  begin_hook();
  if (component_ == nullptr) return call(destruct_);
  return guarded([this]() -> Result<void> {
    component_->destruct();
    return {};
  });
}

executor::Outcome ThreadModule::run(const Cycle& real) noexcept {
  Cycle cycle = real;
  if (logical_) cycle.start = cycle.time;
  if (!watched_.empty()) {
    if (const char* stale = check_inputs(cycle.start); stale != nullptr) return {ErrorType::stale, stale};
  }
  static_cast<void>(take_finished());  // discards a report from a hook other than run()
  serve_cycle(&cycle, log_ring());
  context_.start_ns = to_ns(cycle.start);
  context_.valid_ns = logical_ ? to_ns(cycle.time + cycle.period) : 0;
  context_.flight = flight_;
  live_.take_over();
  const InInstance in_instance{own_threads_};
  try {
    if (component_ != nullptr) {
      component_->run(cycle);
    } else {
      run_();
    }
  } catch (const std::exception& exception) {
    report_failure(exception.what());
  } catch (...) {
    report_failure("threw something that is not a std::exception");
  }
  os::end_forked_copy();
  context_.flight = nullptr;
  serve_cycle(nullptr);
  const char* failure = take_failure();
  if (failure == nullptr) save();
  executor::Outcome outcome{failure};
  outcome.finished = take_finished() && outcome.ok();
  return outcome;
}

executor::Outcome ThreadModule::condition(const Cycle& cycle, bool* ready) noexcept {
  serve_cycle(&cycle, log_ring());
  context_.start_ns = to_ns(cycle.start);
  live_.take_over();
  const InInstance in_instance{own_threads_};
  try {
    if (component_ != nullptr)
      *ready = component_->condition();
    else if (condition_ != nullptr)
      *ready = condition_() != FALSE;
    else
      *ready = has_news(cycle.start);
  } catch (const std::exception& exception) {
    report_failure(exception.what());
  } catch (...) {
    report_failure("threw something that is not a std::exception");
  }
  os::end_forked_copy();
  serve_cycle(nullptr);
  return take_failure();
}

bool ThreadModule::has_news(Instant now) const noexcept {
  return std::any_of(ports_.begin(), ports_.end(), [now](const PortBase* port) {
    return port->direction() == PortDirection::event && port->news_at() <= to_ns(now);
  });
}

bool ThreadModule::has_request() noexcept {
  if (!has_handlers()) return false;
  handler_context_.start_ns = to_ns(now());
  const auto& services = component_->services();
  return std::any_of(services.begin(), services.end(),
                     [](const ServiceBase* service) { return service->has_request(); });
}

bool ThreadModule::serve(bool executing) {
  if (!has_handlers()) return false;
  const char* rejection = executing ? nullptr : "the module of the service is not in EXECUTING";
  handler_context_.start_ns = to_ns(now());
  const InHook in_hook{now(), period_, log_ring()};
  const InInstance in_instance{own_threads_};
  const auto& services = component_->services();
  for (std::size_t n = services.size(); n > 0; --n) {
    if (++served_last_ >= services.size()) served_last_ = 0;
    if (services[served_last_]->handle(rejection)) return true;
  }
  return false;
}

std::vector<std::string> ThreadModule::hooks() const {
  std::vector<std::string> names;
  const auto add = [&names](bool defined, const char* name) {
    if (defined) names.emplace_back(name);
  };
  add(initialize_ != nullptr, "initialize");
  add(start_ != nullptr, "start");
  add(run_ != nullptr, "run");
  add(condition_ != nullptr, "condition");
  add(error_ != nullptr, "error");
  add(recover_ != nullptr, "recover");
  add(destruct_ != nullptr, "destruct");
  return names;
}

}  // namespace takt::host
