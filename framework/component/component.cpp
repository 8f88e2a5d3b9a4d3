#include <takt/component/component.hpp>

#include <algorithm>
#include <utility>

#include <takt/component/module.h>
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
// The host links with this library, so its thread-local storage is in place before any thread starts.
thread_local FixedText<kFailureText> said [[gnu::tls_model("initial-exec")]];
thread_local bool has_said [[gnu::tls_model("initial-exec")]] = false;
thread_local const Cycle* served [[gnu::tls_model("initial-exec")]] = nullptr;
}  // namespace

void say_failure(std::string_view text) noexcept {
  said.assign(text.empty() ? "no reason given" : text);
  has_said = true;
}

const char* take_failure() noexcept {
  if (!has_said) return nullptr;
  has_said = false;
  return said.c_str();
}

void serve_cycle(const Cycle* cycle) noexcept { served = cycle; }
const Cycle* served_cycle() noexcept { return served; }

Nanoseconds Component::period() noexcept { return served == nullptr ? Nanoseconds{0} : served->period; }

void Component::fail(const char* text) noexcept { say_failure(text); }

void ServiceBase::enlist(Component& owner) { owner.services_.push_back(this); }

bool Component::condition() {
  return std::any_of(ports_.begin(), ports_.end(), [](const PortBase* port) {
    return port->direction() == PortDirection::event && port->has_news();
  });
}

// Of the module that this thread loads: its constructors run within dlopen().
namespace {
std::vector<PortBase*>& loose_ports() {
  thread_local std::vector<PortBase*> ports;
  return ports;
}
std::vector<PropertyBase*>& loose_properties() {
  thread_local std::vector<PropertyBase*> properties;
  return properties;
}
}  // namespace

std::vector<PortBase*> take_loose_ports() { return std::exchange(loose_ports(), {}); }
std::vector<PropertyBase*> take_loose_properties() { return std::exchange(loose_properties(), {}); }

namespace detail {
const char* take_said() noexcept { return take_failure(); }
void add_loose_port(PortBase& port) { loose_ports().push_back(&port); }
void remove_loose_port(PortBase& port) noexcept { std::erase(loose_ports(), &port); }
void add_loose_property(PropertyBase& property) { loose_properties().push_back(&property); }
void remove_loose_property(PropertyBase& property) noexcept { std::erase(loose_properties(), &property); }
}  // namespace detail

}  // namespace takt

extern "C" {

void takt_fail(const char* text) { takt::say_failure(text == nullptr ? "" : text); }

uint64_t takt_cycle(void) { return takt::served == nullptr ? 0 : takt::served->number; }
int64_t takt_release_ns(void) { return takt::served == nullptr ? 0 : takt::to_ns(takt::served->time); }
int64_t takt_period_ns(void) { return takt::served == nullptr ? 0 : takt::served->period.count(); }
}
