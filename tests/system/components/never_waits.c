/* Calls initPeriodExe(), then sleeps and never calls waitPeriod(). */
#define _POSIX_C_SOURCE 200809L
#include <takt/process.h>
#include <unistd.h>

int main(void) {
  initPeriodExe();
  for (;;) pause();
}
