/* The interface of a process module (.exe) in the form of the paper's Figures 9 and 11. The program is the
 * user's own; it is started by takt-node and linked with libtakt_process:
 *
 *   int main(int argc, char* argv[]) {          int main(int argc, char* argv[]) {
 *     initPeriodExe();                            initSporadicExe();
 *     while (1) {                                 while (1) {
 *       waitPeriod();                               if (!condition()) continue;   calls waitSporadic() first
 *       ... periodic body                           ... sporadic body
 *     }                                           }
 *   }                                           }
 *
 * The module's properties are the program's arguments, one "name=value" each, in the order of the descriptor.
 * A program that declares its properties (<takt/property.h>, in C++ <takt/process.hpp>) finds their values in
 * them, and takes no others; one that declares none takes any, and reads its arguments itself. Standard
 * output and error are shown with the module's name, line by line.
 *
 * `takt check`, `takt describe` and a node start a program whose ports are connected, with its arguments, to
 * have it say its ports: initPeriodExe() or initSporadicExe() does so and ends it. What is before that call
 * in main() reads arguments, declares ports and, of arguments that it cannot take, says on standard error
 * what is wrong; what would be right, a line each, and ends with a status that is not 0. It starts nothing
 * else: no device is opened before the call.
 *
 * A program that is started again because it crashed finds there what it had saved: <takt/saved.h>, in C++
 * takt::Saved.
 *
 * When the device ends the module, waitPeriod() and waitSporadic() do not return but end the program by
 * exit(0), so that output is flushed and atexit() functions run. A program that never comes back to them gets
 * SIGTERM, then SIGKILL. */
#ifndef TAKT_PROCESS_H
#define TAKT_PROCESS_H

#include <stdint.h>

#include <takt/port.h>
#include <takt/property.h>
#include <takt/saved.h>
#include <takt/text.h>

#ifndef TRUE
#define TRUE 1
#endif
#ifndef FALSE
#define FALSE 0
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Ties this program to the node that started it; INITIALIZE is reached. Call it once, from the thread that
 * will wait. Ends the program with status 1 and a reason on standard error when it was not started by
 * takt-node, or as the other kind. */
void initPeriodExe(void);
void initSporadicExe(void);

/* Says that the body is done (or, the first time, that the module is ready: START is reached) and waits for
 * the next release. Sleeps to a margin before the release, spins on a word in shared memory, and falls back
 * to a futex. */
void waitPeriod(void);
void waitSporadic(void);

/* The release that is being served: its place in the module's grid, counting from 0 with gaps where releases
 * were missed; its instant in nanoseconds of CLOCK_MONOTONIC; the period in nanoseconds (of the executor's
 * row for a sporadic module). */
uint64_t takt_cycle(void);
int64_t takt_release_ns(void);
int64_t takt_period_ns(void);

#ifdef __cplusplus
}
#endif

#endif
