// A periodic process module for `takt bench`, written like the paper's Figure 9. The arguments file=... and
// releases=... have the same meaning as the properties of bench_periodic.so.
#include <chrono>
#include <cstdlib>
#include <string>

#include <takt/process.hpp>

#include "filter_step.hpp"
#include "recording.hpp"

namespace {

takt::bench::Recording jitter;
std::string file;

void write_at_the_end() { static_cast<void>(jitter.write(file)); }

}  // namespace

int main(int argc, char* argv[]) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("file=", 0) == 0) file = argument.substr(5);
    if (argument.rfind("releases=", 0) == 0) jitter.reserve(std::stoul(argument.substr(9)));
  }
  if (!file.empty()) std::atexit(write_at_the_end);
  takt::bench::Work work;
  initPeriodExe();
  while (true) {
    waitPeriod();
    const std::int64_t now = std::chrono::steady_clock::now().time_since_epoch().count();
    jitter.note(static_cast<std::int64_t>(takt_cycle()), takt_release_ns() - now);
    work.step();
  }
}
