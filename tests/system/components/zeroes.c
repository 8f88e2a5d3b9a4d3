/* In release number `after` (default 100), writes zeros to all memory that the program can write to and that
 * it shares with takt-node, with the scheduler or with other programs. Then the program continues normally.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <takt/process.h>

#include "argument.h"

static void fill_with_zeros(void) {
  FILE* maps = fopen("/proc/self/maps", "r");
  char line[512];
  while (maps != NULL && fgets(line, sizeof line, maps) != NULL) {
    uintptr_t begin = 0;
    uintptr_t end = 0;
    if (strstr(line, " rw-s ") == NULL || strstr(line, "memfd:takt-") == NULL) continue;
    if (sscanf(line, "%" SCNxPTR "-%" SCNxPTR, &begin, &end) == 2) memset((void*)begin, 0, end - begin);
  }
  if (maps != NULL) fclose(maps);
}

int main(int argc, char* argv[]) {
  const long after = (long)argument_number(argc, argv, "after", 100, 1, 1e9);
  initPeriodExe();
  for (long release = 1;; ++release) {
    waitPeriod();
    if (release != after) continue;
    fill_with_zeros();
    puts("filled with zeros");
  }
  return 0;
}
