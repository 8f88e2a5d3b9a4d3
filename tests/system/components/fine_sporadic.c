/* A correct sporadic process module. Its condition holds at every `every`-th release (default 10), and its
 * body then spins for `ns` nanoseconds (default 0). At the end it prints how often the condition held. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <takt/process.h>
#include <time.h>

#include "argument.h"

static long every = 10;
static long releases = 0;
static long count = 0;

static int64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

static void say_count(void) { printf("released %ld times, condition held %ld times\n", releases, count); }

static int condition(void) {
  waitSporadic();
  return ++releases % every == 0 ? TRUE : FALSE;
}

int main(int argc, char* argv[]) {
  every = (long)argument_number(argc, argv, "every", 10, 1, 1e9);
  const int64_t length = (int64_t)argument_number(argc, argv, "ns", 0, 0, 1e12);
  initSporadicExe();
  atexit(say_count);
  while (1) {
    if (!condition()) continue;
    ++count;
    const int64_t end = now_ns() + length;
    while (now_ns() < end) {
    }
  }
  return 0;
}
