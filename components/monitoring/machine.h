/* Parses the kernel's text files on load and memory; the caller passes the text. */
#ifndef TAKT_COMPONENTS_MACHINE_H
#define TAKT_COMPONENTS_MACHINE_H

#include <stdio.h>
#include <string.h>

/* The load over the last minute, from the text of /proc/loadavg; negative if it is missing. */
static inline double machine_load(const char* loadavg) {
  double load = -1;
  return sscanf(loadavg, "%lf", &load) == 1 ? load : -1;
}

/* The value of `name`, for example "MemAvailable", in KiB from the text of /proc/meminfo; negative if it
 * is missing. */
static inline long long machine_memory_kib(const char* meminfo, const char* name) {
  const size_t length = strlen(name);
  for (const char* line = meminfo; line != NULL; line = strchr(line, '\n')) {
    if (*line == '\n') ++line;
    if (strncmp(line, name, length) != 0 || line[length] != ':') continue;
    long long value = -1;
    return sscanf(line + length + 1, "%lld", &value) == 1 ? value : -1;
  }
  return -1;
}

#endif
