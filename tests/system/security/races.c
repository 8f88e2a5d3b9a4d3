/* Plays an attacker who replaces a component between two uses of its path, and wins every race. This library is preloaded into Takt's
   programs. The file named by TAKT_RACE holds one word of 64 bits: how many more times a path in the folder TAKT_RACE_FOLDER leads to the
   component itself. After that, it leads to the file of the same name in the folder TAKT_RACE_OTHER. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static _Atomic int64_t* left;

__attribute__((constructor)) static void attach(void) {
  const char* path = getenv("TAKT_RACE");
  const int fd = path == NULL ? -1 : open(path, O_RDWR | O_CLOEXEC);
  void* data = fd < 0 ? MAP_FAILED : mmap(NULL, sizeof *left, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (fd >= 0) close(fd);
  if (data != MAP_FAILED) left = data;
}

/* Returns the path of the file that the program finds under `path`. */
static const char* found(const char* path, char other[4096]) {
  const char* folder = getenv("TAKT_RACE_FOLDER");
  if (left == NULL || folder == NULL || path == NULL || strncmp(path, folder, strlen(folder)) != 0) return path;
  const char* ending = strrchr(path, '.');
  if (ending == NULL || (strcmp(ending, ".so") != 0 && strcmp(ending, ".exe") != 0)) return path;
  if (atomic_fetch_sub(left, 1) > 0) return path;
  snprintf(other, 4096, "%s%s", getenv("TAKT_RACE_OTHER"), path + strlen(folder));
  return other;
}

#define REAL(name) \
  static __typeof__(&name) real; \
  char other[4096]; \
  if (real == NULL) *(void**)&real = dlsym(RTLD_NEXT, #name)

#define OPEN(name)                                \
  int name(const char* path, int flags, ...) {    \
    REAL(name);                                   \
    va_list more;                                 \
    va_start(more, flags);                        \
    const unsigned mode = va_arg(more, unsigned); \
    va_end(more);                                 \
    return real(found(path, other), flags, mode); \
  }
OPEN(open)
OPEN(open64)

FILE* fopen(const char* restrict path, const char* restrict mode) {
  REAL(fopen);
  return real(found(path, other), mode);
}
FILE* fopen64(const char* restrict path, const char* restrict mode) {
  REAL(fopen64);
  return real(found(path, other), mode);
}
void* dlopen(const char* path, int flags) {
  REAL(dlopen);
  return real(found(path, other), flags);
}
int execve(const char* path, char* const arguments[], char* const environment[]) {
  REAL(execve);
  return real(found(path, other), arguments, environment);
}
int execv(const char* path, char* const arguments[]) {
  REAL(execv);
  return real(found(path, other), arguments);
}
