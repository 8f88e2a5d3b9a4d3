/* A correct periodic process module that checks its grid: release n is due at T0 + n x period. At the end
 * it prints T0 in ns, the number of its releases, and the number of releases off this grid. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <takt/process.h>

static int64_t first_t0 = 0;
static uint64_t last = 0;
static long count = 0;
static long strayed = 0;

static void say_result(void) { printf("grid %" PRId64 " %ld %ld\n", first_t0, count, strayed); }

int main(void) {
  initPeriodExe();
  atexit(say_result);
  while (1) {
    waitPeriod();
    const int64_t t0 = takt_release_ns() - (int64_t)takt_cycle() * takt_period_ns();
    if (count++ == 0) {
      first_t0 = t0;
    } else if (t0 != first_t0 || takt_cycle() <= last) {
      ++strayed;
    }
    last = takt_cycle();
  }
  return 0;
}
