/* A sporadic process module in C: a program of its own that the scheduler releases, and that looks what has come. */
#include <takt/process.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies what comes in, when it comes.");
TAKT_EVENT_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "What it is multiplied with.");

int main(void) {
  @name@_types_Sample value;
  initSporadicExe();
  /* Here one may allocate, open and take time: the module is ready when it waits for the first time. */
  while (1) {
    waitSporadic();
    while (takt_read(&in, &value)) {
      value.value *= gain;
      takt_write(&out, &value);
    }
  }
}
