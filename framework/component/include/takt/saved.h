/* What a module in C keeps when its process dies: one variable of the file, of at most 4096 bytes and without
 * pointers. static struct { double sum; } kept; TAKT_SAVED(1, kept)           1 is its version: count it up
 * when its meaning changes After each run() that did not fail, of a program in each waitPeriod() or
 * waitSporadic(), it is copied into memory that outlives the process; what was saved with the same version
 * and size is in it again before start() is called, of a program when initPeriodExe() or initSporadicExe()
 * returns. */
#ifndef TAKT_SAVED_H
#define TAKT_SAVED_H

#include <stdint.h>

struct takt_saved_state {
  uint32_t version;
  uint32_t size; /* bytes */
  void* data;
};
#ifdef __cplusplus
#define TAKT_SAVED(version, variable)                                                         \
  extern "C" __attribute__((visibility("default"))) const struct takt_saved_state takt_saved; \
  const struct takt_saved_state takt_saved = {version, (uint32_t)sizeof(variable), &(variable)};
#else
#define TAKT_SAVED(version, variable)    \
  __attribute__((visibility("default"))) \
  const struct takt_saved_state takt_saved = {version, (uint32_t)sizeof(variable), &(variable)};
#endif

#endif
