/* Calls all functions of sins.h in every run(), or, as a process module, in every execution of its body. */
#define _GNU_SOURCE
#ifdef PROGRAM
#include <takt/process.h>
#else
#include <takt/module.h>
#endif

#include "sins.h"

static void all_of_them(void) {
  sin_allocate();
  sin_lock();
  sin_sleep();
  sin_print();
  sin_fault();
  sin_call();
}

#ifdef PROGRAM
int main(void) {
  initPeriodExe();
  sins_prepare(); /* locked memory cannot cause page faults */
  while (1) {
    waitPeriod();
    all_of_them();
  }
}
#else
void start(void) { sins_prepare(); }
void run(void) { all_of_them(); }
#endif
