/* A temperature loop with a period of 300 us: a process module in plain C, as in the paper's Figure 9. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <takt/process.h>

#include "temperature_loop.h"

TAKT_TEXT("Temperature loop of an extruder's heating zone.");
TAKT_NUMBER(low_c, 60, 30, 300, "degC", "The lower set point.");
TAKT_NUMBER(high_c, 80, 30, 300, "degC", "The higher set point.");
TAKT_NUMBER(hold_s, 10, 0.01, 3600, "s", "Time at each set point.");
TAKT_NUMBER(gain_w_k, 30, 0.1, 1000, "W/K", "Proportional gain.");
TAKT_NUMBER(integral_s, 4, 0.1, 1000, "s", "Integral time.");
TAKT_NUMBER(power_w, 400, 1, 5000, "W", "Maximum power of the heater.");

static struct zone zone;
static struct heater_loop loop;
static double wanted;
static unsigned long long releases;

/* Prints a summary. exit() calls this function; waitPeriod() calls exit() when the node ends the module. */
static void print_summary(void) {
  printf("control4: %llu releases, zone at %.2f C, set point %.2f C, heater at %.1f W\n", releases,
         zone.sensor, wanted, loop.integral);
}

int main(void) {
  const double room = 20;
  initPeriodExe();
  zone = zone_at_room(room);
  loop.gain = gain_w_k;
  loop.integral_time = integral_s;
  loop.power_limit = power_w;
  atexit(print_summary);
  const double dt = (double)takt_period_ns() * 1e-9;
  double time = 0;

  while (1) {
    waitPeriod();
    time += dt;
    if (time >= 2 * hold_s) time = 0;
    wanted = time < hold_s ? high_c : low_c;
    zone_step(&zone, heater_loop_step(&loop, wanted, zone.sensor, dt), dt);
    ++releases;
  }
  return 0;
}
