/* Returns from main with `status` (default 0) after `after` releases (default 100). If `after` is 0, the
 * program returns before it waits for a release. */
#include <takt/process.h>

#include "argument.h"

int main(int argc, char* argv[]) {
  long after = (long)argument_number(argc, argv, "after", 100, 0, 1e9);
  const int status = (int)argument_number(argc, argv, "status", 0, 0, 255);
  initPeriodExe();
  while (after-- > 0) waitPeriod();
  return status;
}
