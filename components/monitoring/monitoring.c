/* A non-real-time module is a plain program: the node starts it, it gets idle CPU time, and SIGTERM ends it.
 * This module prints the machine's load and memory once a second. The program calls no Takt function; a
 * constant contains its sentence for `takt describe`. */
#define _POSIX_C_SOURCE 200809L
#include "machine.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <takt/text.h>
#include <time.h>

TAKT_TEXT("Prints the load and memory of the machine once a second.");

static const char* text_of(const char* path) {
  static char text[8192];
  FILE* file = fopen(path, "r");
  size_t length = 0;
  if (file != NULL) {
    length = fread(text, 1, sizeof text - 1, file);
    fclose(file);
  }
  text[length] = '\0';
  return text;
}

int main(void) {
  setvbuf(stdout, NULL, _IOLBF, 0);
  /* The program blocks the signals and waits for them. So it needs no handler, and no signal is lost between
   * a check and the sleep. */
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  sigprocmask(SIG_BLOCK, &ends, NULL);

  const struct timespec second = {1, 0};
  unsigned long lines = 0;
  for (;;) {
    const int signal_number = sigtimedwait(&ends, NULL, &second);
    if (signal_number > 0) break;
    if (errno == EINTR) continue;
    const double load = machine_load(text_of("/proc/loadavg"));
    const char* meminfo = text_of("/proc/meminfo");
    const long long total = machine_memory_kib(meminfo, "MemTotal");
    const long long available = machine_memory_kib(meminfo, "MemAvailable");
    printf("load %.2f, memory %lld of %lld MiB available\n", load, available / 1024, total / 1024);
    ++lines;
  }
  printf("monitoring: ended after %lu lines\n", lines);
  return 0;
}
