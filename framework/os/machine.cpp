#include <takt/os/machine.hpp>

#include <sys/utsname.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <sstream>
#include <thread>

#include <takt/os/environment.hpp>
#include <takt/os/real_time.hpp>

namespace takt::os {

namespace {

std::string first_line(const char* path) {
  std::ifstream file{path};
  std::string line;
  std::getline(file, line);
  return line;
}

/// The value of the first line that begins with `key`, in a file of "key : value" lines.
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

Machine describe_machine() {
  Machine machine;
  machine.name = host_name();
  machine.processor = value_of("/proc/cpuinfo", "model name");
  machine.processors = static_cast<int>(std::thread::hardware_concurrency());
  utsname kernel{};
  if (::uname(&kernel) == 0) machine.kernel = std::string{kernel.release} + " " + kernel.version;
  machine.clock_source = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  machine.governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  machine.isolated = first_line("/sys/devices/system/cpu/isolated");
  const std::string flags = " " + value_of("/proc/cpuinfo", "flags") + " ";
  machine.hypervisor = flags.find(" hypervisor ") != std::string::npos;
  machine.throttled = throttled_share();
  const std::string load = first_line("/proc/loadavg");
  machine.load = load.substr(0, load.find(' ', load.find(' ', load.find(' ') + 1) + 1));
  return machine;
}

Nanoseconds stolen_time() {
  constexpr int kSteal = 8;  // the words of its line, of which the first is "cpu"
  std::istringstream line{first_line("/proc/stat")};
  std::string name;
  line >> name;
  std::int64_t ticks = 0;
  for (int i = 0; i < kSteal && line >> ticks; ++i) continue;
  const std::int64_t second = ::sysconf(_SC_CLK_TCK);
  return line && second > 0 ? Nanoseconds{ticks * (1'000'000'000 / second)} : Nanoseconds{0};
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
