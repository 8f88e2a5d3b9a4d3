/** @file
 * The interface of a process module (.exe) in the form of the paper's Figures 9 and 11. The module is a
 * separate program. It links with libtakt_process, and takt-node starts it:
 *
 *     int main(int argc, char* argv[]) {      int main(int argc, char* argv[]) {
 *       initPeriodExe();                        initSporadicExe();
 *       while (1) {                             while (1) {
 *         waitPeriod();                           if (!condition()) continue;   // calls waitSporadic() first
 *         ... periodic body                       ... sporadic body
 *       }                                       }
 *     }                                       }
 *
 * Properties: the program gets the module's properties as arguments, one "name=value" each, in the order of
 * the descriptor. If the program declares properties (<takt/property.h>, in C++ <takt/process.hpp>), they
 * take their values from the arguments, and other arguments are rejected. A program without declared
 * properties accepts any argument and reads the arguments itself.
 *
 * Output: takt-node shows the lines of standard output and standard error with the module's name.
 *
 * Descriptions: if ports of the program are connected, `takt check`, `takt describe` and takt-node first
 * start it with its arguments to learn its ports. initPeriodExe() or initSporadicExe() then reports the ports
 * and ends the program. So the code before this call in main() must only read arguments and declare ports. It
 * must not open devices or start anything else. If the program cannot accept an argument, it should print
 * "what is wrong; what to do" on standard error, one line for each argument, and exit with a status other
 * than 0.
 *
 * Saved state: a program that is started again after a crash has its saved state back when initPeriodExe() or
 * initSporadicExe() returns; see <takt/saved.h>, in C++ takt::Saved.
 *
 * End: when the device ends the module, waitPeriod() and waitSporadic() do not return. They end the program
 * with exit(0), so output is flushed and atexit() functions run. A program that never calls them again gets
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

/** Connects a periodic program to the node that started it; the module is then in INITIALIZE. Call it once,
 * from the thread that will call waitPeriod(). Real-time threads must not call it. If takt-node did not start
 * the program, or the descriptor does not say periodic, the function prints the reason on standard error and
 * ends the program with status 1. */
void initPeriodExe(void);
/** Connects a sporadic program to the node that started it; the module is then in INITIALIZE. Call it once,
 * from the thread that will call waitSporadic(). Real-time threads must not call it. If takt-node did not
 * start the program, or the descriptor does not say sporadic, the function prints the reason on standard
 * error and ends the program with status 1. */
void initSporadicExe(void);

/** Reports that the body is done, and waits for the next release. The first call reports that the module is
 * ready; the module is then in START. The function sleeps until shortly before the release, and then spins on
 * a word in shared memory. If the release is late, it sleeps on a futex. Call it from the thread that called
 * initPeriodExe(). */
void waitPeriod(void);
/** Reports that the body is done, and waits for the next release of a sporadic module. The first call reports
 * that the module is ready; the module is then in START. Call it from the thread that called
 * initSporadicExe(). */
void waitSporadic(void);

/** The number of the release that the body serves, on the module's grid. It counts from 0, with gaps for
 * missed releases. A real-time thread may call it. */
uint64_t takt_cycle(void);
/** The instant at which the release that the body serves was due, in ns of CLOCK_MONOTONIC. A real-time
 * thread may call it. */
int64_t takt_release_ns(void);
/** The period of the module in ns; for a sporadic module, the period of its executor's rows. A real-time
 * thread may call it. */
int64_t takt_period_ns(void);

#ifdef __cplusplus
}
#endif

#endif
