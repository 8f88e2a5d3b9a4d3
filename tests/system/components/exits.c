/* Returns from main with `status` (0) after `after` releases (100). With 0, it does so before it first waits.
 */
#include <takt/process.h>

#include "argument.h"

int main(int argc, char* argv[]) {
  long after = (long)argument_number(argc, argv, "after", 100, 0, 1e9);
  const int status = (int)argument_number(argc, argv, "status", 0, 0, 255);
  initPeriodExe();
  while (after-- > 0) waitPeriod();
  return status;
}
