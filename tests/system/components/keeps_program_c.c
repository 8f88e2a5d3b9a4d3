/* A process module in C that counts the executions of its body in a saved value, and prints the value that
 * it restored. */
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
