/* A module in C, or a program if PROGRAM is defined, all of whose texts contain control characters. */
#include "every_period.h"

#include <stdio.h>

#include "controls.h"

TAKT_TEXT("text " CONTROLS);
TAKT_STRING(label, "default " CONTROLS, "property " CONTROLS);
TAKT_NUMBER(number, 0.5, 0, 2, "unit " CONTROLS, "property " CONTROLS);

static void body(void) {
#ifdef PROGRAM
  static int runs = 0;
  if (runs++ == 0) printf("a last line without a line feed " CONTROLS);
#endif
  if (takt_cycle() % 100 != 5) return;
  takt_log(TAKT_LOG_ERROR, "log %s", CONTROLS);
  fprintf(stderr, "error \xff %s\n", CONTROLS);
}
