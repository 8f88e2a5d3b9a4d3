/* Logs a warning in every 100th cycle: as a thread module, or as a process module if PROGRAM is defined. */
#include "every_period.h"

static void body(void) {
  if (takt_cycle() % 100 == 0) takt_log(TAKT_LOG_WARNING, "%s is at %5.2f of %d", "level", 1.5, 3);
}
