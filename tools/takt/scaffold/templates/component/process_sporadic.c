/* A sporadic process module in C: a separate program that the scheduler releases to check for events. */
#include <takt/process.h>

#include <@name@_types_c.h>

TAKT_TEXT("Multiplies each input by a gain.");
TAKT_EVENT_PORT(@name@_types_Sample, in);
TAKT_OUT_PORT(@name@_types_Sample, out);
TAKT_NUMBER(gain, 2, -1000, 1000, "", "The factor.");

int main(void) {
  @name@_types_Sample value;
  initSporadicExe();
  /* Prepare here: allocate, open files. The module is ready when it waits for the first time. */
  while (1) {
    waitSporadic();
    while (takt_read(&in, &value)) {
      value.value *= gain;
      takt_write(&out, &value);
    }
  }
}
