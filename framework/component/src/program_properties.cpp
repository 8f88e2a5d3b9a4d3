#include "program_properties.hpp"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/component/live_properties.hpp>
#include <takt/component/property.hpp>
#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/fork_guard.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/real_time.hpp>

namespace takt {

namespace {

// The properties of this program. The constructors of the program's global variables use this struct before
// main() begins.
struct Properties {
  std::vector<PropertyBase*> all;  // in the order of construction
  std::vector<std::pair<std::string, std::string>> given;
  Problems refused;

  // Reads the values of properties from the arguments. An argument such as --mode=fast is not a property.
  Properties() {
    for (const std::string& argument : os::program_arguments()) {
      const auto equals = argument.find('=');
      if (equals != std::string::npos && argument[0] != '-')
        given.emplace_back(argument.substr(0, equals), argument.substr(equals + 1));
    }
  }
};

Properties& properties() {
  static Properties ours;
  return ours;
}

bool has(const std::string& name) {
  return std::any_of(properties().all.begin(), properties().all.end(),
                     [&](const PropertyBase* property) { return property->name() == name; });
}

/// The thread that answers the node's requests, and the properties as this thread and the body share them.
/// Never destroyed, because the thread may still wait for a request when the program ends.
struct Server {
  explicit Server(channel::ReleaseSlot& s) : slot(s) {}

  channel::ReleaseSlot& slot;
  LiveProperties live;
  std::mutex answering;  // held while the thread uses the slot and the properties
  bool ended = false;    // guarded by `answering`; true: they may no longer exist

  void answer(std::uint32_t number) {
    const channel::PropertyRequest& request = slot.property_request;
    const std::string name{request.name.view()};
    const auto done =
        request.sets != 0 ? live.set({{name, std::string{request.value.view()}}}) : Result<void>{};
    const Result<std::string> value = done ? live.get(name) : done.problems();
    slot.property_answer.answer(number, value.ok(), value ? *value : in_words(value.problems()));
  }
  // `answered` is the number of the last request that the thread need not answer.
  void serve(std::uint32_t answered) {
    while (true) {
      os::futex_wait(slot.property_request.number, answered, ~0U);
      const std::lock_guard lock{answering};
      if (ended) return;
      const std::uint32_t number = slot.property_request.number.load(std::memory_order_acquire);
      if (number != answered) answer(number);
      answered = number;
    }
  }
  void end() noexcept {
    if (os::is_forked_copy()) return;  // the copy has no such thread, but the mutex may be locked
    const std::lock_guard lock{answering};
    ended = true;
  }
};

Server* server = nullptr;  // null until serve_program_properties() has started the thread

}  // namespace

std::vector<PropertyBase*> take_loose_properties() { return properties().all; }

namespace detail {

void add_loose_property(PropertyBase& property) {
  Properties& ours = properties();
  ours.all.push_back(&property);
  for (const auto& [name, value] : ours.given) {
    if (name != property.name()) continue;
    if (const auto assigned = property.assign(value); !assigned)
      ours.refused.insert(ours.refused.end(), assigned.problems().begin(), assigned.problems().end());
  }
}

void remove_loose_property(PropertyBase& property) noexcept {
  if (server != nullptr) server->end();
  std::erase(properties().all, &property);
}

}  // namespace detail

Problems check_program_properties() {
  Properties& ours = properties();
  Problems problems = check_declared(ours.all, "this program");
  problems.insert(problems.end(), ours.refused.begin(), ours.refused.end());
  std::vector<std::string_view> names;
  for (const PropertyBase* property : ours.all) names.emplace_back(property->name());
  names.emplace_back(kLogLevelProperty);
  for (const auto& [name, value] : ours.given) {
    if (!ours.all.empty() && !has(name))
      problems.push_back(fail("this program has no property " + in_quotes(name), suggestion(name, names)));
  }
  return problems;
}

Result<void> serve_program_properties(channel::ReleaseSlot& slot) {
  if (properties().all.empty()) return {};
  auto* const created = new Server{slot};
  created->live.serve(properties().all, "this program");
  const std::uint32_t before = slot.property_request.number.load(std::memory_order_acquire);
  auto thread = os::Thread::start(
      {.name = "takt-properties", .handles_signals = false}, [created, before] { created->serve(before); },
      nullptr);
  if (!thread) return thread.problems();
  thread->detach();
  server = created;
  // exit() calls this function before it destroys the program's global variables.
  std::atexit([] { server->end(); });
  slot.property_answer.serves.store(1, std::memory_order_release);
  return {};
}

void take_over_program_properties() noexcept {
  if (server != nullptr) server->live.take_over();
}

std::string program_properties_json() {
  std::string list;
  for (const PropertyBase* property : properties().all) {
    const auto member = [&list](const char* name, const std::string& value) {
      list += in_json(name) + ":" + in_json(value) + ",";
    };
    list += list.empty() ? "{" : ",{";
    member("name", property->name());
    member("type", to_text(property->type()));
    member("default", property->default_text());
    member("range", property->range_text());
    member("min", property->min_text());
    member("max", property->max_text());
    member("unit", property->unit());
    list += in_json("text") + ":" + in_json(property->text()) + "}";
  }
  return "[" + list + "]";
}

std::string in_json(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    constexpr char kDigits[] = "0123456789abcdef";
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      result += {'\\', c};
    else if (code < 0x20)
      result += std::string{"\\u00"} + kDigits[code >> 4] + kDigits[code & 15];
    else
      result += c;
  }
  return result + '"';
}

}  // namespace takt
