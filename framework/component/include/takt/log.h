/** @file
 * Log lines in C. Every hook of a thread module, including run(), and a process module can write them:
 *
 *     takt_log(TAKT_LOG_INFO, "lost the part at %.2f m", x);
 *
 * The call copies the format and the arguments into a ring in shared memory; the node formats the text. `takt
 * log` and the web page show the text. A real-time thread may call takt_log().
 *
 * The format is that of printf() with these conversions: %d %i %u %x %X %o %c %f %e %g %s and %%, with flags,
 * width and precision below 100, and the lengths hh, h, l, ll, z, j and t. `*`, %n, %p and long double are
 * not supported. A call has at most 8 arguments. Takt keeps at most 216 bytes of the format and the text
 * arguments together. */
#ifndef TAKT_LOG_H
#define TAKT_LOG_H

/** How important a log line is. A module logs only lines that are at least as important as its log level, by
 * default TAKT_LOG_INFO. `takt set DEVICE.MODULE log-level debug` changes the log level. */
enum {
  TAKT_LOG_ERROR = 1,   /**< something failed */
  TAKT_LOG_WARNING = 2, /**< something is not as it should be */
  TAKT_LOG_INFO = 3,    /**< an event of normal operation */
  TAKT_LOG_DEBUG = 4    /**< details for the author */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Logs a line, with the number of the module's release (takt_cycle()) and the time at which its run began.
 * Does nothing if the line is less important than the module's log level. If the ring is full, the line is
 * dropped and counted. Call this from the thread that runs the hook; lines that other threads of a thread
 * module log are lost. The function takes no lock, allocates nothing and makes no system call, so a real-time
 * thread may call it. */
void takt_log(int level, const char* format, ...) __attribute__((format(printf, 2, 3)));

/** Reports whether the module is in a safe stop: 1 if it is, 0 if it is not. In a safe stop, the module works
 * as intended, and keeps its machine stopped for safety. `takt status`, `takt watch`, `takt log` and the web
 * page show the safe stop while the module is in EXECUTING. A reset of the module ends the safe stop. Call
 * this from the thread that runs the hook. The function takes no lock, allocates nothing and makes no system
 * call, so a real-time thread may call it. */
void takt_safe_stop(int stopped);

#ifdef __cplusplus
}
#endif

#endif
