#include <takt/component.hpp>

#include <algorithm>
#include <string>
#include <utility>

#include <takt/module.h>
#include <takt/component/current_cycle.hpp>
#include <takt/component/failure.hpp>
#include <takt/core/fixed_text.hpp>

namespace takt {

const char* to_text(ErrorType type) noexcept {
  switch (type) {
    case ErrorType::none:
      return "none";
    case ErrorType::failure:
      return "failure";
    case ErrorType::budget:
      return "budget";
    case ErrorType::start:
      return "start";
    case ErrorType::crash:
      return "crash";
    case ErrorType::hang:
      return "hang";
    case ErrorType::deadline:
      return "deadline";
    case ErrorType::stale:
      return "stale";
    case ErrorType::overrun:
      return "overrun";
  }
  return "?";
}

namespace {
// The host links with this library, so the library's thread-local storage exists before any thread starts.
// The TLS model initial-exec requires this.
thread_local FixedText<kFailureText> reported_failure [[gnu::tls_model("initial-exec")]];
thread_local bool has_reported_failure [[gnu::tls_model("initial-exec")]] = false;
thread_local bool has_finished [[gnu::tls_model("initial-exec")]] = false;
thread_local const Cycle* served [[gnu::tls_model("initial-exec")]] = nullptr;
thread_local channel::LogRing* served_log [[gnu::tls_model("initial-exec")]] = nullptr;
thread_local bool constructing [[gnu::tls_model("initial-exec")]] = false;
}  // namespace

void report_failure(std::string_view text) noexcept {
  reported_failure.assign(text.empty() ? "no reason given" : text);
  has_reported_failure = true;
}

const char* take_failure() noexcept {
  if (!has_reported_failure) return nullptr;
  has_reported_failure = false;
  return reported_failure.c_str();
}

void report_finished() noexcept { has_finished = true; }
bool take_finished() noexcept { return std::exchange(has_finished, false); }

void serve_cycle(const Cycle* cycle, channel::LogRing* log) noexcept {
  served = cycle;
  served_log = log;
}
const Cycle* served_cycle() noexcept { return served; }

ConstructingComponent::ConstructingComponent() noexcept { constructing = true; }
ConstructingComponent::~ConstructingComponent() { constructing = false; }

Nanoseconds Component::period() noexcept { return served == nullptr ? Nanoseconds{0} : served->period; }

void Component::fail(const char* text) noexcept { report_failure(text); }
void Component::finish() noexcept { report_finished(); }

Result<void> Component::restore(const SavedBefore& before) {
  return takt::fail("the saved value has version " + std::to_string(before.version) +
                        ", but this component saves another version or size",
                    "override restore() to convert the saved value");
}

void ServiceBase::enlist(Component& owner) { owner.services_.push_back(this); }

bool Component::condition() {
  return std::any_of(ports_.begin(), ports_.end(), [](const PortBase* port) {
    return port->direction() == PortDirection::event && port->has_news();
  });
}

namespace {
/// Returns this thread's list of the ports (or properties, or Saved objects) of the module in C form that the
/// thread is loading. The constructors that dlopen() runs fill the list. Returns null if the list is already
/// destroyed; ports that are global variables are destroyed later than the list.
template <class T>
std::vector<T*>* loose() {
  thread_local bool gone = false;
  struct List {
    std::vector<T*> all;
    ~List() { gone = true; }
  };
  thread_local List list;
  return gone ? nullptr : &list.all;
}
template <class T>
void remove_loose(T& one) noexcept {
  if (auto* all = loose<T>()) std::erase(*all, &one);
}
}  // namespace

std::vector<PortBase*> take_loose_ports() { return std::exchange(*loose<PortBase>(), {}); }
std::vector<PropertyBase*> take_loose_properties() { return std::exchange(*loose<PropertyBase>(), {}); }
std::vector<SavedBase*> take_loose_saved() { return std::exchange(*loose<SavedBase>(), {}); }

namespace detail {
LogTarget log_target() noexcept {
  if (served == nullptr) return {};
  return {served_log, served->number, to_ns(served->start)};
}
const char* take_reported_failure() noexcept { return take_failure(); }
bool report_late(const std::string& what) {
  if (served == nullptr || constructing) return false;
  report_failure(what +
                 " was created after the constructor, so it would have no effect; make it a member of the "
                 "component, or create it in the constructor");
  return true;
}
void add_loose_port(PortBase& port) { loose<PortBase>()->push_back(&port); }
void remove_loose_port(PortBase& port) noexcept { remove_loose(port); }
void add_loose_property(PropertyBase& property) { loose<PropertyBase>()->push_back(&property); }
void remove_loose_property(PropertyBase& property) noexcept { remove_loose(property); }
void add_loose_saved(SavedBase& saved) { loose<SavedBase>()->push_back(&saved); }
void remove_loose_saved(SavedBase& saved) noexcept { remove_loose(saved); }
}  // namespace detail

}  // namespace takt

extern "C" {

void takt_fail(const char* text) { takt::report_failure(text == nullptr ? "" : text); }
void takt_finish(void) { takt::report_finished(); }

uint64_t takt_cycle(void) { return takt::served == nullptr ? 0 : takt::served->number; }
int64_t takt_release_ns(void) { return takt::served == nullptr ? 0 : takt::to_ns(takt::served->time); }
int64_t takt_period_ns(void) { return takt::served == nullptr ? 0 : takt::served->period.count(); }
}
