/* Writes to address 0 after `after` releases (default 100). If `after` is 0, the program does so before it
 * waits for a release. */
#include <takt/process.h>

#include "argument.h"

int main(int argc, char* argv[]) {
  long after = (long)argument_number(argc, argv, "after", 100, 0, 1e9);
  volatile int* volatile nowhere = NULL;
  initPeriodExe();
  while (after-- > 0) waitPeriod();
  *nowhere = 1;
  return 0;
}
