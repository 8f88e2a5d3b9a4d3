/** @file
 * The saved state of a module in C: one variable, whose value survives the death of the module's process. It
 * has at most 4096 bytes and no pointers:
 *
 *     static struct { double sum; } kept;
 *     TAKT_SAVED(1, kept)
 *
 * The 1 is the version of the variable: increase it when its meaning changes.
 *
 * After each run() that did not fail, Takt copies the variable into memory that outlives the process. In a
 * process module, waitPeriod() and waitSporadic() copy the variable. After a crash, Takt restores the saved
 * value before it calls start(). In a process module, initPeriodExe() or initSporadicExe() restores the saved
 * value. A value that was saved with another version or size is not restored. */
#ifndef TAKT_SAVED_H
#define TAKT_SAVED_H

#include <stdint.h>

/** A saved variable, as TAKT_SAVED declares it. */
struct takt_saved_state {
  uint32_t version; /**< version of the variable's meaning */
  uint32_t size;    /**< size of the variable, in bytes */
  void* data;       /**< the variable */
};
/** Declares the saved variable of a thread or process module. At file scope, once. */
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
