// Where a number was measured, without which it says nothing.
#pragma once

#include <benchmark/benchmark.h>
#include <sys/utsname.h>

#include <fstream>
#include <sstream>
#include <string>

namespace takt::bench {

inline std::string first_line(const std::string& path) {
  std::ifstream file{path};
  std::string line;
  std::getline(file, line);
  return line;
}

/// User, system, steal and the rest, in ticks since the machine started.
struct Ticks {
  unsigned long long all = 0;
  unsigned long long stolen = 0;
};
inline Ticks ticks() {
  std::istringstream line{first_line("/proc/stat")};
  std::string name;
  line >> name;
  Ticks result;
  unsigned long long n = 0;
  for (int i = 0; i < 8 && line >> n; ++i) {
    result.all += n;
    if (i == 7) result.stolen = n;
  }
  return result;
}

/// Printed with the results: processor, kernel, clock source, load.
inline void describe_machine() {
  std::ifstream info{"/proc/cpuinfo"};
  std::string line;
  while (std::getline(info, line)) {
    if (line.rfind("model name", 0) == 0) break;
  }
  utsname kernel{};
  ::uname(&kernel);
  benchmark::AddCustomContext("processor", line.substr(line.find(':') + 2));
  benchmark::AddCustomContext("kernel", std::string{kernel.release} + " " + kernel.version);
  benchmark::AddCustomContext("clock source",
                              first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource"));
  benchmark::AddCustomContext("load", first_line("/proc/loadavg"));
}

}  // namespace takt::bench
