#include <takt/os/platform.hpp>

#include <unistd.h>

#include <ctime>
#include <fstream>
#include <sstream>

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/machine.hpp>

namespace takt::os {

namespace {

/// Reads a file with lines of the form "key : value". Returns the value of the first line that begins with
/// `key`.
std::string value_of(const char* path, const std::string& key) {
  std::ifstream file{path};
  std::string line;
  while (std::getline(file, line)) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t begin = line.find_first_not_of(" \t", line.find(':') + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

}  // namespace

Platform describe_platform() {
  const Machine machine = read_machine();
  Platform platform;
  platform.name = host_name();
  platform.processor = value_of("/proc/cpuinfo", "model name");
  // ARM processors have no model name. The machine's is better than nothing.
  if (platform.processor.empty()) platform.processor = text_of("/sys/firmware/devicetree/base/model");
  platform.processors = static_cast<int>(machine.online.size());
  platform.kernel = machine.kernel + " " + machine.version;
  platform.clock_source = machine.clock;
  if (!machine.processors.empty()) platform.governor = machine.processors.front().governor;
  platform.isolated = model::cpus_text(machine.isolated);
  platform.hypervisor = !machine.hypervisor.empty();
  if (machine.throttling) {
    platform.throttled = std::chrono::duration<double>(machine.throttling->kept).count() /
                         std::chrono::duration<double>(machine.throttling->period).count();
  }
  const std::string load = text_of("/proc/loadavg");
  platform.load = load.substr(0, load.find(' ', load.find(' ', load.find(' ') + 1) + 1));
  return platform;
}

Nanoseconds stolen_time() {
  const std::int64_t second = ::sysconf(_SC_CLK_TCK);
  const auto time = read_processor_time();
  return time && second > 0 ? Nanoseconds{static_cast<std::int64_t>(time->stolen) * (1'000'000'000 / second)}
                            : Nanoseconds{0};
}

std::uint64_t memory_of(int pid) {
  const std::string path = "/proc/" + std::to_string(pid) + "/smaps_rollup";
  std::istringstream kib{value_of(path.c_str(), "Pss:")};
  std::uint64_t count = 0;
  kib >> count;
  return count * 1024;
}

Nanoseconds thread_time() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return Nanoseconds{static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec};
}

}  // namespace takt::os
