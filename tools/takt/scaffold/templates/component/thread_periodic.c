/* A periodic thread module in C: the scheduler calls run() in every period. */
#include <takt/module.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies the input by a gain.");
TAKT_IN_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "The factor.");

/* initialize() may allocate memory and open files. To fail, call takt_fail("what is wrong"). */
void initialize(void) {}

/* run() runs on the real-time thread: it must not lock, allocate memory, make system calls or print. To log,
   use takt_log(). */
void run(void) {
  @name@_types_Sample value;
  if (!takt_read(&in, &value)) return; /* no new sample since the last run() */
  value.value *= gain;
  takt_write(&out, &value);
}
