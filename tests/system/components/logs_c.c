/* Logs a warning in every 100th cycle: as a thread module, or as a process module if PROGRAM is defined. */
#ifdef PROGRAM
#include <takt/process.h>
#else
#include <takt/module.h>
#endif

static void body(void) {
  if (takt_cycle() % 100 == 0) takt_log(TAKT_LOG_WARNING, "%s is at %5.2f of %d", "level", 1.5, 3);
}

#ifdef PROGRAM
int main(void) {
  initPeriodExe();
  while (1) {
    waitPeriod();
    body();
  }
}
#else
void run(void);
void run(void) { body(); }
#endif
