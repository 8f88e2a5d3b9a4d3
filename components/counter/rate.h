/* The mathematics of the component counter: parts per minute. Real-time threads may use everything here. */
#ifndef COUNTER_RATE_H
#define COUNTER_RATE_H

#include <stdint.h>

enum { COUNTER_SLOTS = 60 };

/* A ring buffer of the counts in each of the last 60 seconds; `at` is the index of the newest count. */
struct counter_rate {
  uint32_t slots[COUNTER_SLOTS];
  uint32_t at;
  uint32_t filled; /* complete seconds so far, at most 59 */
  uint32_t last;   /* the count at the last step */
  double second;   /* elapsed part of the current slot's second */
};

/* `parts` is the count so far, `dt` the time in s since the last step. Returns the parts per minute, from the
 * last 60 s. During the first 60 s it extrapolates from the time so far. */
static inline double counter_rate_step(struct counter_rate* rate, uint32_t parts, double dt) {
  uint32_t sum = 0;
  double seconds = 0;
  if (parts > rate->last) rate->slots[rate->at] += parts - rate->last; /* a lower count has restarted */
  rate->last = parts;
  rate->second += dt;
  for (uint32_t i = 0; i < COUNTER_SLOTS; ++i) sum += rate->slots[i];
  seconds = rate->filled + rate->second;
  if (rate->second >= 1) {
    rate->second -= 1;
    rate->at = (rate->at + 1) % COUNTER_SLOTS;
    rate->slots[rate->at] = 0;
    if (rate->filled < COUNTER_SLOTS - 1) ++rate->filled;
  }
  return seconds > 0 ? 60 * sum / seconds : 0;
}

#endif
