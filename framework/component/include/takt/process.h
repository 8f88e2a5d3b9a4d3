/** @file
 * The interface of a process module (.exe) in the form of the paper's Figures 9 and 11. The module is a
 * separate program. It links with libtakt_process, and takt-node starts it:
 *
 *     int main(int argc, char* argv[]) {      int main(int argc, char* argv[]) {
 *       initPeriodExe();                        initSporadicExe();
 *       while (1) {                             while (1) {
 *         waitPeriod();                           waitSporadic();
 *         ... periodic body                       ... sporadic body
 *       }                                       }
 *     }                                       }
 *
 * waitPeriod() or waitSporadic() must be the first call in the loop, because the program waits there for its
 * release. In Figure 11, the program's own function condition() calls waitSporadic().
 *
 * Arguments: the program gets the `<arguments>` of the descriptor in their order, and then the module's
 * properties, one "name=value" each. If the program declares properties (<takt/property.h>, in C++
 * <takt/process.hpp>), they take their values from the arguments, and an argument "name=value" for any other
 * name is rejected. The program reads all other arguments itself, such as "--camera" and "--mode=fast".
 *
 * Output: takt-node shows the lines of standard output and standard error with the module's name. takt_log()
 * writes log lines without a system call.
 *
 * Descriptions: `takt check`, `takt describe` and takt-node first start a periodic or sporadic program with
 * its arguments, only to learn its ports and whether it is periodic or sporadic. initPeriodExe() or
 * initSporadicExe() then reports these facts and ends the program. So the code before this call in main()
 * must only read arguments and declare ports. It must not open devices or start anything else. If the program
 * cannot accept an argument, it should print "what is wrong; what to do" on standard error, one line for each
 * argument, and exit with a status other than 0.
 *
 * Saved state: a program that is started again after a crash has its saved state back when initPeriodExe() or
 * initSporadicExe() returns; see <takt/saved.h>, in C++ takt::Saved.
 *
 * End: when the device ends the module, waitPeriod() and waitSporadic() do not return. They end the program
 * with exit(0), so output is flushed and atexit() functions run. A program that calls neither function again
 * gets SIGTERM, then SIGKILL. A program that ends with status 0 by itself has finished: the module goes to
 * DESTRUCT and is not started again. Any other status, or a signal, is an error, and Takt starts the program
 * again as `<recovery>` says. */
#ifndef TAKT_PROCESS_H
#define TAKT_PROCESS_H

#ifdef TAKT_THREAD_MODULE
#error <takt/process.h> is for programs: use takt_add_process; a component includes <takt/component.hpp> or <takt/module.h>
#endif

#include <stdint.h>

#include <takt/log.h>
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

/** Connects a periodic process module to the node that started its program. The module is then in INITIALIZE.
 * Call it once, from the thread that will call waitPeriod(). Real-time threads must not call it. If takt-node
 * did not start the program, or the descriptor does not declare the module periodic, the function prints the
 * reason on standard error and ends the program with status 1. */
void initPeriodExe(void);
/** Connects a sporadic process module to the node that started its program. The module is then in INITIALIZE.
 * Call it once, from the thread that will call waitSporadic(). Real-time threads must not call it. If
 * takt-node did not start the program, or the descriptor does not declare the module sporadic, the function
 * prints the reason on standard error and ends the program with status 1. */
void initSporadicExe(void);

/** Reports that the body is done, and waits for the next release. The first call reports that the module is
 * ready; the module is then in START. The function sleeps until shortly before the release, and then spins on
 * a word in shared memory. If the release is late, the function sleeps on a futex. Call it from the thread
 * that called initPeriodExe(). */
void waitPeriod(void);
/** Reports that the body is done, and waits for the next release of a sporadic module: with immediate
 * dispatch, until an event has arrived; otherwise until the next row has ended, even if no event has arrived.
 * The first call reports that the module is ready; the module is then in START. Call it from the thread that
 * called initSporadicExe(). */
void waitSporadic(void);

/** Returns the number of the release for which the body runs. Releases are numbered from 0; a missed release
 * leaves a gap. For a sporadic module, this is the number of the executor's row that released it (with
 * immediate dispatch, of the next row). A real-time thread may call it. */
uint64_t takt_cycle(void);
/** Returns the instant at which the release was due for which the body runs, in ns of CLOCK_MONOTONIC. A
 * real-time thread may call it. */
int64_t takt_release_ns(void);
/** Returns the period of the module in ns; for a sporadic module, the basic period of its executor. A
 * real-time thread may call it. */
int64_t takt_period_ns(void);

#ifdef __cplusplus
}
#endif

#endif
