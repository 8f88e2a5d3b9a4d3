/* A process module in C: counts the parts that a belt brings in a minute. */
#include <takt/process.h>

#include <line_c.h>

#include "rate.h"

TAKT_TEXT("Counts the parts that a belt brings in a minute.");
TAKT_IN_PORT(line_BeltState, state);
TAKT_OUT_PORT(line_Throughput, throughput);

int main(void) {
  struct counter_rate rate = {{0}, 0, 0, 0, 0};
  line_BeltState belt;
  line_Throughput output = {0, 0};

  initPeriodExe();
  while (1) {
    waitPeriod();
    takt_read(&state, &belt); /* keeps the last value if there is no new one */
    output.parts = belt.parts;
    output.per_minute = counter_rate_step(&rate, belt.parts, (double)takt_period_ns() * 1e-9);
    takt_write(&throughput, &output);
  }
}
