/* A process module whose body spins in every `every`-th release (default 1) for `ns` nanoseconds, by
 * default for one and a half periods. */
#define _POSIX_C_SOURCE 200809L
#include <takt/process.h>
#include <time.h>

#include "argument.h"

static int64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

int main(int argc, char* argv[]) {
  const double ns = argument_number(argc, argv, "ns", -1, 0, 1e12);
  const long every = (long)argument_number(argc, argv, "every", 1, 1, 1e9);
  initPeriodExe();
  const int64_t length = ns < 0 ? takt_period_ns() * 3 / 2 : (int64_t)ns;
  long releases = 0;
  while (1) {
    waitPeriod();
    if (++releases % every != 0) continue;
    const int64_t end = now_ns() + length;
    while (now_ns() < end) {
    }
  }
  return 0;
}
