/* A non-real-time process module that does not call Takt. It prints when it was started, and returns from
 * main with `status` (default 0) after `ms` milliseconds (default 100). */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

#include "argument.h"

int main(int argc, char* argv[]) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  printf("started %lld\n", (long long)now.tv_sec * 1000000000 + now.tv_nsec);
  fflush(stdout);
  const long ms = (long)argument_number(argc, argv, "ms", 100, 0, 1e6);
  const int status = (int)argument_number(argc, argv, "status", 0, 0, 255);
  const struct timespec pause = {ms / 1000, ms % 1000 * 1000000};
  nanosleep(&pause, NULL);
  return status;
}
