/* A good sporadic process: its condition holds at every `every`-th release (10). Says at the end how often.
 */
#include <stdio.h>
#include <stdlib.h>
#include <takt/process.h>

#include "../../../components/common/argument.h"

static long every = 10;
static long releases = 0;
static long count = 0;

static void say_count(void) { printf("released %ld times, condition held %ld times\n", releases, count); }

static int condition(void) {
  waitSporadic();
  return ++releases % every == 0 ? TRUE : FALSE;
}

int main(int argc, char* argv[]) {
  every = (long)argument_number(argc, argv, "every", 10, 1, 1e9);
  initSporadicExe();
  atexit(say_count);
  while (1) {
    if (!condition()) continue;
    ++count;
  }
  return 0;
}
