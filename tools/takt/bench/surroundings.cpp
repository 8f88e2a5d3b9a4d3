#include "surroundings.hpp"

#include <chrono>
#include <cmath>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace takt::bench {

namespace {
std::string or_else(const std::string& text, const char* otherwise) {
  return text.empty() ? otherwise : text;
}
}  // namespace

std::vector<std::pair<std::string, std::string>> described(const os::Platform& machine) {
  return {{"machine", or_else(machine.name, "unknown")},
          {"CPU", fmt::format("{}, {} online{}", or_else(machine.processor, "unknown"), machine.processors,
                              machine.hypervisor ? ", in a virtual machine" : "")},
          {"kernel", or_else(machine.kernel, "unknown")},
          {"clock source", or_else(machine.clock_source, "unknown")},
          {"governor", or_else(machine.governor, "none visible")},
          {"isolated", or_else(machine.isolated, "no CPU")},
          {"throttling", machine.throttled == 0
                             ? "off"
                             : fmt::format("the kernel denies real-time threads {:.0f} % of each second",
                                           100 * machine.throttled)},
          {"load", or_else(machine.load, "unknown")}};
}

std::string machine_text(const os::Platform& machine) {
  std::string text;
  for (const auto& [what, how] : described(machine)) text += fmt::format("{:<13} {}\n", what, how);
  return text;
}

nlohmann::ordered_json machine_json(const os::Platform& machine) {
  return {{"name", machine.name},
          {"processor", machine.processor},
          {"processors", machine.processors},
          {"virtual", machine.hypervisor},
          {"kernel", machine.kernel},
          {"clock_source", machine.clock_source},
          {"governor", machine.governor},
          {"isolated", machine.isolated},
          {"throttled", machine.throttled},
          {"load", machine.load}};
}

std::string date_text(std::int64_t wall_ns) {
  const std::time_t seconds = wall_ns / 1'000'000'000;
  return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(seconds));
}

std::string in_us(double ns) {
  const double us = ns / 1e3;
  const double size = std::abs(us);
  return fmt::format("{:.{}f}", us, size < 10 ? 2 : size < 100 ? 1 : 0);
}

}  // namespace takt::bench
