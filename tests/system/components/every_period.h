/* Makes a thread module in C, or a periodic process module if PROGRAM is defined, that calls body() in every
 * period. The file that includes this header defines body(). */
#pragma once

#ifdef PROGRAM
#include <takt/process.h>
#else
#include <takt/module.h>
#endif

static void body(void);

#ifdef PROGRAM
int main(void) {
  initPeriodExe();
  while (1) {
    waitPeriod();
    body();
  }
}
#else
void run(void) { body(); }
#endif
