/* A thread module in C, or a process module if PROGRAM is defined, with properties of every kind. It
 * prints their values at its beginning and at its end. */
#ifdef PROGRAM
#include <takt/process.h>
#else
#include <takt/module.h>
#endif

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

TAKT_TEXT("Properties of every kind, & \"nothing\" else.");
TAKT_NUMBER(speed, 0.5, 0, 2, "m/s", "Of the belt.");
TAKT_NUMBER(free_number, -1, -INFINITY, INFINITY, "", "Without bounds.");
TAKT_INTEGER(count, 3, 1, INT64_MAX, "parts", "At a time.");
TAKT_FLAG(on, 1, "Whether it does anything.");
TAKT_STRING(label, "none", "What it is called.");

static void print(const char* when) {
  fprintf(stderr, "%s: speed %g, free_number %g, count %lld, on %d, label %s\n", when, speed, free_number,
          (long long)count, on, label);
}

#ifdef PROGRAM
static void at_the_end(void) { print("end"); }

int main(void) {
  initPeriodExe();
  print("begin");
  atexit(at_the_end);
  while (1) waitPeriod();
}
#else
void initialize(void) { print("begin"); }
void run(void) {}
void destruct(void) { print("end"); }
#endif
