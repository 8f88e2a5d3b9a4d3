/* A process module that records when each execution of its body begins, and spins in the body for `ns`
 * nanoseconds (default 0). At its end it writes one line for each execution to `file`: the release and the
 * beginning, both in ns of the monotonic clock. */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <takt/process.h>
#include <time.h>

#include "argument.h"

enum { kMostBodies = 1 << 16 };

static struct {
  int64_t release;
  int64_t begin;
} bodies[kMostBodies];
static int count = 0;
static const char* file_name = "";

static int64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static void write_bodies(void) {
  FILE* file = fopen(file_name, "w");
  if (file == NULL) return;
  for (int i = 0; i < count; ++i) fprintf(file, "%" PRId64 " %" PRId64 "\n", bodies[i].release, bodies[i].begin);
  fclose(file);
}

int main(int argc, char* argv[]) {
  const int64_t length = (int64_t)argument_number(argc, argv, "ns", 0, 0, 1e9);
  file_name = argument_text(argc, argv, "file", "begins");
  initPeriodExe();
  atexit(write_bodies);
  while (1) {
    waitPeriod(); /* ends the process when the cell ends */
    const int64_t begin = now_ns();
    if (count < kMostBodies) {
      bodies[count].release = takt_release_ns();
      bodies[count].begin = begin;
      ++count;
    }
    while (now_ns() < begin + length) {
    }
  }
}
