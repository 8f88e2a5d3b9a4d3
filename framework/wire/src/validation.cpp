#include <takt/wire/validation.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include <takt/core/control_character.hpp>
#include <takt/core/words.hpp>

namespace takt::wire {

namespace {

template <class... Fields>
bool are_names(const Fields&... fields) noexcept {
  return (is_name({fields.c_str(), fields.size()}) && ...);
}

template <class... Fields>
bool are_given(const Fields&... fields) noexcept {
  return ((fields.size() > 0) && ...);
}

template <template <std::size_t> class FixedString, std::size_t N>
void clean(FixedString<N>& field) noexcept {
  std::array<char, N + 1> text{};
  const std::size_t size = std::min(field.size(), N);
  std::memcpy(text.data(), field.c_str(), size);
  for (std::size_t at = 0; at < size;) {
    const std::size_t length = utf8_length({text.data() + at, size - at});
    if (length == 0) {
      text[at++] = '?';
      continue;
    }
    const bool kept = text[at] == '\n' || text[at] == '\t';
    if (!kept && is_control_character({text.data() + at, length})) std::memset(text.data() + at, ' ', length);
    at += length;
  }
  field.assign(text.data(), size);
}

// Returns true if the value is one of the enumerators of its type. The generated enumerations are unsigned
// and begin with 0.
template <class Enum>
bool exists(Enum value, Enum last) noexcept {
  return static_cast<std::uint32_t>(value) <= static_cast<std::uint32_t>(last);
}

template <class Status>
bool is_named(const Status& status) noexcept {
  return are_given(status.path(), status.cell(), status.device(), status.name()) &&
         are_names(status.path(), status.cell(), status.device(), status.name());
}

template <class Part>
bool is_part(const Part& part) noexcept {
  return part.parts() >= 1 && part.part() < part.parts();
}

}  // namespace

bool is_name(std::string_view text) noexcept {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0 || is_control_character(text.substr(0, length))) return false;
    text.remove_prefix(length);
  }
  return true;
}

bool validate(LifecycleStatus& status) noexcept {
  clean(status.text());
  return is_named(status) && exists(status.state(), STATE_DESTRUCT) &&
         exists(status.previous_state(), STATE_DESTRUCT) && exists(status.event(), EVENT_RESET) &&
         exists(status.error(), ERROR_OVERRUN);
}

bool validate(DeviceStatus& status) noexcept {
  clean(status.text());
  clean(status.host_name());
  return are_given(status.path(), status.cell(), status.device(), status.node()) &&
         are_names(status.path(), status.cell(), status.device(), status.node(), status.deployment(),
                   status.undeployed(), status.transaction()) &&
         std::all_of(status.echoes().begin(), status.echoes().end(),
                     [](const StatusEcho& echo) { return are_names(echo.node()); }) &&
         exists(status.stage(), STAGE_FINAL) && exists(status.state(), DEVICE_ENDED) &&
         exists(status.health(), HEALTH_FAILED);
}

bool validate(ModuleStatistics& statistics) noexcept { return is_named(statistics); }
bool validate(ExecutorStatistics& statistics) noexcept { return is_named(statistics); }

bool validate(PortStatus& status) noexcept {
  clean(status.incompatible());
  clean(status.forced());
  return is_named(status) && are_given(status.port()) && are_names(status.port(), status.type());
}

bool validate(FaultEvent& event) noexcept {
  clean(event.cause());
  clean(event.attachment());
  return are_given(event.path(), event.cell(), event.device()) &&
         are_names(event.path(), event.cell(), event.device(), event.name()) &&
         exists(event.kind(), FAULT_ACKNOWLEDGED) && exists(event.severity(), SEVERITY_ERROR) &&
         exists(event.error(), ERROR_OVERRUN);
}

bool validate(Command& command) noexcept {
  clean(command.value());
  return is_part(command) && are_given(command.id(), command.device()) &&
         exists(command.kind(), COMMAND_ACKNOWLEDGE) &&
         are_names(command.id(), command.device(), command.node(), command.module_name(),
                   command.deployment(), command.property());
}

bool validate(Reply& reply) noexcept {
  clean(reply.text());
  clean(reply.value());
  return is_part(reply) && are_given(reply.id(), reply.device(), reply.node()) &&
         exists(reply.code(), REPLY_LATE) && exists(reply.state(), STATE_DESTRUCT) &&
         are_names(reply.id(), reply.device(), reply.node(), reply.module_name());
}

}  // namespace takt::wire
