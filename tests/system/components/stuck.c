/* After `after` releases (default 100), the body sleeps for ever. SIGTERM ends the program. */
#define _POSIX_C_SOURCE 200809L
#include <takt/process.h>
#include <unistd.h>

#include "argument.h"

int main(int argc, char* argv[]) {
  long after = (long)argument_number(argc, argv, "after", 100, 0, 1e9);
  initPeriodExe();
  while (after-- > 0) waitPeriod();
  for (;;) pause();
}
