/* A thread module in C, or a periodic process module if PROGRAM is defined, that forwards the samples that
 * it reads. */
#ifdef PROGRAM
#include <takt/process.h>
#else
#include <takt/module.h>
#endif

#include <samples_c.h>

TAKT_IN_PORT(samples_Count, in);
TAKT_OUT_PORT(samples_Count, out);

static void pass_on(void) {
  samples_Count count;
  while (takt_read(&in, &count)) takt_write(&out, &count);
}

#ifdef PROGRAM
int main(void) {
  initPeriodExe();
  while (1) {
    waitPeriod();
    pass_on();
  }
}
#else
void run(void) { pass_on(); }
#endif
