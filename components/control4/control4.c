/* A process module in plain C, in the form of the paper's Figure 9: a temperature loop, 300 us. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <takt/process.h>

#include "../common/argument.h"
#include "temperature_loop.h"

static struct zone zone;
static struct heater_loop loop;
static double wanted;
static unsigned long long releases;

/* waitPeriod() ends the program by exit() when the device ends the module. */
static void say_goodbye(void) {
  printf("control4: %llu releases, %.2f C of %.2f C, heater at %.1f W\n", releases, zone.sensor, wanted,
         loop.integral);
}

int main(int argc, char* argv[]) {
  const double low = argument_number(argc, argv, "low_c", 60, 30, 300);
  const double high = argument_number(argc, argv, "high_c", 80, 30, 300);
  const double hold = argument_number(argc, argv, "hold_s", 10, 0.01, 3600);
  const double room = 20;
  zone = zone_at_room(room);
  loop.gain = argument_number(argc, argv, "gain_w_k", 30, 0.1, 1000);
  loop.integral_time = argument_number(argc, argv, "integral_s", 4, 0.1, 1000);
  loop.power_limit = argument_number(argc, argv, "power_w", 400, 1, 5000);
  initPeriodExe();
  atexit(say_goodbye);
  const double dt = (double)takt_period_ns() * 1e-9;
  double time = 0;

  while (1) {
    waitPeriod();
    time += dt;
    if (time >= 2 * hold) time = 0;
    wanted = time < hold ? high : low;
    zone_step(&zone, heater_loop_step(&loop, wanted, zone.sensor, dt), dt);
    ++releases;
  }
  return 0;
}
