// A correct sporadic module. Its condition is true at every `every`-th check (default 10), and run() then
// spins for `ns` nanoseconds (default 0). It writes the number of runs to `file` at the end.
#include "count_file.hpp"

#include <chrono>

#include <takt/module.h>

static long long every = 10;
static long long checks = 0;
static long long count = 0;
static std::chrono::nanoseconds length{};
static std::string file;

extern "C" {
void initialize(irp::Property const& property) {
  every = property.get("every", 10LL, 1, 1000000000);
  length = std::chrono::nanoseconds{property.get("ns", 0LL, 0, 60000000000)};
  file = property.get("file", "");
}
int condition(void) { return ++checks % every == 0 ? TRUE : FALSE; }
void run(void) {
  ++count;
  const auto end = std::chrono::steady_clock::now() + length;
  while (std::chrono::steady_clock::now() < end) {
  }
}
void destruct(void) { write_count(file, count); }
}
