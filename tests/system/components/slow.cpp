// Spins for `ns` nanoseconds (default 50000) in every `every`-th run (default 1). Writes the number of runs
// to `file` at the end.
#include "count_file.hpp"

#include <chrono>

#include <takt/module.h>

static std::chrono::nanoseconds length{};
static long long every = 1;
static long long runs = 0;
static std::string file;

extern "C" {
void initialize(irp::Property const& property) {
  length = std::chrono::nanoseconds{property.get("ns", 50000LL, 0, 60000000000)};
  every = property.get("every", 1LL, 1, 1000000000);
  file = property.get("file", "");
}
void run(void) {
  if (++runs % every != 0) return;
  const auto end = std::chrono::steady_clock::now() + length;
  while (std::chrono::steady_clock::now() < end) {
  }
}
void destruct(void) { write_count(file, runs); }
}
