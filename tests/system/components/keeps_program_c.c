/* A program in C that counts its bodies in a saved value, and prints what it restored. It never crashes. */
#include <stdint.h>
#include <stdio.h>
#include <takt/process.h>

static struct {
  uint64_t bodies;
} kept;
TAKT_SAVED(1, kept)

int main(void) {
  initPeriodExe();
  printf("c has %llu\n", (unsigned long long)kept.bodies);
  for (;;) {
    waitPeriod();
    ++kept.bodies;
  }
}
