/* A periodic process module in C: a separate program that the scheduler releases in every period. */
#include <takt/process.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies the input by a gain.");
TAKT_IN_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "The factor.");

int main(void) {
  @name@_types_Sample value;
  initPeriodExe();
  /* Prepare here: allocate, open files. The module is ready when it waits for the first time. */
  while (1) {
    waitPeriod();
    if (!takt_read(&in, &value)) continue; /* no new sample since the last release */
    value.value *= gain;
    takt_write(&out, &value);
  }
}
