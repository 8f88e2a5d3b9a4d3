/* A periodic process module in C: a program of its own that the scheduler releases every period. */
#include <takt/process.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies what comes in.");
TAKT_IN_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "What it is multiplied with.");

int main(void) {
  @name@_types_Sample value;
  initPeriodExe();
  /* Here one may allocate, open and take time: the module is ready when it waits for the first time. */
  while (1) {
    waitPeriod();
    if (!takt_read(&in, &value)) continue; /* nothing has come since the last release */
    value.value *= gain;
    takt_write(&out, &value);
  }
}
