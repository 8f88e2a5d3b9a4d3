// Calls abort() in its `after`-th run (default 100). If `how` is throw, this run throws an exception instead.
// The exception ends the process, because run() is noexcept.
#include <takt/module.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

static std::string how;
static long long after = 100;
static long long runs = 0;

static void end() {
  if (how == "throw") throw std::runtime_error("no part in\nthe gripper");
  std::abort();
}

extern "C" {
void initialize(irp::Property const& property) {
  how = property.get("how", "abort");
  after = property.get("after", 100LL, 1, 1000000000);
}
void run(void) noexcept {
  if (++runs == after) end();
}
}
