/* The mathematics of the component control4: the temperature loop of an extruder's heating zone.
 * Temperatures are in degrees Celsius, times in seconds, power in watts. */
#ifndef TAKT_COMPONENTS_TEMPERATURE_LOOP_H
#define TAKT_COMPONENTS_TEMPERATURE_LOOP_H

/* A heater in a metal block, which loses heat to the room. The sensor follows the block with a lag. */
struct zone {
  double capacity; /* J/K */
  double loss;     /* W/K */
  double lag;      /* s, time constant of the sensor */
  double room;     /* C */
  double block;    /* C */
  double sensor;   /* C, measured value */
};

static inline struct zone zone_at_room(double room) {
  /* A small zone, so that its temperature changes visibly within a minute. */
  const struct zone zone = {40.0, 0.5, 0.3, room, room, room};
  return zone;
}

static inline void zone_step(struct zone* zone, double power, double dt) {
  zone->block += (power - zone->loss * (zone->block - zone->room)) / zone->capacity * dt;
  zone->sensor += (zone->block - zone->sensor) / zone->lag * dt;
}

/* A PI loop whose output is limited to 0 (a heater cannot cool) and the maximum power. The integral stops
 * when it would drive the output further beyond a limit, and is itself limited to the heater's range. */
struct heater_loop {
  double gain;          /* W/K */
  double integral_time; /* s */
  double power_limit;   /* W */
  double integral;      /* W */
};

static inline double heater_loop_step(struct heater_loop* loop, double wanted, double measured, double dt) {
  const double error = wanted - measured;
  const double power = loop->gain * error + loop->integral;
  const double bounded = power < 0 ? 0 : power > loop->power_limit ? loop->power_limit : power;
  if (power == bounded || (power > bounded) != (error > 0)) {
    loop->integral += loop->gain * error / loop->integral_time * dt;
    if (loop->integral < 0) loop->integral = 0;
    if (loop->integral > loop->power_limit) loop->integral = loop->power_limit;
  }
  return bounded;
}

#endif
