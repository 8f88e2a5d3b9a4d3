/* A periodic thread module in C: run() is called by the scheduler every period. */
#include <takt/module.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies what comes in.");
TAKT_IN_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "What it is multiplied with.");

/* Here one may allocate, open and fail: takt_fail("what is wrong"); */
void initialize(void) {}

/* On the real-time thread: no lock, no allocation, no system call, no log. */
void run(void) {
  @name@_types_Sample value;
  if (!takt_read(&in, &value)) return; /* nothing has come since the last run() */
  value.value *= gain;
  takt_write(&out, &value);
}
