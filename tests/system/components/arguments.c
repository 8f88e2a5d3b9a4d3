/* A periodic process module that, like a legacy program, reads its arguments itself and prints them, one
 * on each line. It also declares a property. */
#include <stdio.h>
#include <takt/process.h>

TAKT_NUMBER(speed, 1, 0, 10, "m/s", "A property beside the arguments.");

int main(int argc, char* argv[]) {
  initPeriodExe();
  for (int i = 1; i < argc; ++i) printf("argument %d: [%s]\n", i, argv[i]);
  printf("speed %g\n", speed);
  while (1) waitPeriod();
}
