// A module whose `after`-th run (default 100) never returns. If `deaf` is true, this run blocks all signals. If
// `file` is set, this run creates the file.
#include <takt/module.h>

#include <csignal>
#include <fstream>
#include <string>

static long long after = 100;
static bool deaf = false;
static std::string file;
static long long runs = 0;
static volatile bool for_ever = true;

extern "C" {
void initialize(irp::Property const& property) {
  after = property.get("after", 100LL, 1, 1000000000);
  deaf = property.get("deaf", false);
  file = property.get("file", "");
}
void run(void) {
  if (++runs != after) return;
  sigset_t all;
  sigfillset(&all);
  if (!file.empty()) std::ofstream{file} << "runs";
  if (deaf) pthread_sigmask(SIG_BLOCK, &all, nullptr);
  while (for_ever) {
  }
}
}
