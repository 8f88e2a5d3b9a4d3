/* A sporadic thread module in C: the scheduler calls run() when condition() holds. */
#include <takt/module.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies each input by a gain.");
TAKT_EVENT_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "The factor.");

/* initialize() may allocate memory and open files. To fail, call takt_fail("what is wrong"). */
void initialize(void) {}

/* Both functions run on the real-time thread: they must not lock, allocate, make system calls or print. To log,
   use takt_log(). */
int condition(void) { return takt_has_news(&in) ? TRUE : FALSE; }

void run(void) {
  @name@_types_Sample value;
  while (takt_read(&in, &value)) {
    value.value *= gain;
    takt_write(&out, &value);
  }
}
