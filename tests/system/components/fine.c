/* A correct periodic process module: counts its releases and prints the number at the end. */
#include <stdio.h>
#include <stdlib.h>
#include <takt/process.h>

static long count = 0;

static void say_count(void) { printf("released %ld times\n", count); }

int main(void) {
  initPeriodExe();
  atexit(say_count);
  while (1) {
    waitPeriod();
    ++count;
  }
  return 0;
}
