/* A module in C that counts its runs in a saved value, and prints in start() what it restored. */
#include <stdint.h>
#include <stdio.h>
#include <takt/module.h>

static struct {
  uint64_t runs;
} kept;
TAKT_SAVED(1, kept)

void start(void) { printf("c has %llu\n", (unsigned long long)kept.runs); }
void run(void) { ++kept.runs; }
