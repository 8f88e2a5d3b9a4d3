/* A module in C, or a program if PROGRAM is defined, all of whose texts contain control characters. */
#ifdef PROGRAM
#include <takt/process.h>
#else
#include <takt/module.h>
#endif

#include <stdio.h>

#include "controls.h"

TAKT_TEXT("text " CONTROLS);
TAKT_STRING(label, "default " CONTROLS, "property " CONTROLS);
TAKT_NUMBER(number, 0.5, 0, 2, "unit " CONTROLS, "property " CONTROLS);

static void body(void) {
  if (takt_cycle() % 100 != 5) return;
  takt_log(TAKT_LOG_ERROR, "log %s", CONTROLS);
  fprintf(stderr, "error \xff %s\n", CONTROLS);
}

#ifdef PROGRAM
int main(void) {
  initPeriodExe();
  printf("a last line without a line feed " CONTROLS);
  while (1) {
    waitPeriod();
    body();
  }
}
#else
void run(void);
void run(void) { body(); }
#endif
