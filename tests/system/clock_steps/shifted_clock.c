/* Gives one process a wall clock that a test can set. This library is preloaded and adds an offset to CLOCK_REALTIME. The file named by
   TAKT_SHIFTED_CLOCK holds two words of 64 bits: the nanoseconds to add, and the number of waits until an instant of the wall clock.
   Takt must not wait for such an instant, because setting the clock would move the end of the wait. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

struct shared {
  _Atomic int64_t shift_ns;
  _Atomic int64_t waits;
};

static struct shared* shared;

__attribute__((constructor)) static void attach(void) {
  const char* path = getenv("TAKT_SHIFTED_CLOCK");
  const int fd = path == NULL ? -1 : open(path, O_RDWR | O_CLOEXEC);
  void* data = fd < 0 ? MAP_FAILED : mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (fd >= 0) close(fd);
  if (data != MAP_FAILED) shared = data;
}

static int64_t shift(void) { return shared == NULL ? 0 : atomic_load(&shared->shift_ns); }

static int64_t to_ns(const struct timespec* t) { return (int64_t)t->tv_sec * 1000000000 + t->tv_nsec; }
static struct timespec from_ns(int64_t ns) { return (struct timespec){.tv_sec = ns / 1000000000, .tv_nsec = ns % 1000000000}; }

int clock_gettime(clockid_t clock, struct timespec* t) {
  static int (*real)(clockid_t, struct timespec*);
  if (real == NULL) *(void**)&real = dlsym(RTLD_NEXT, "clock_gettime");
  const int result = real(clock, t);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) *t = from_ns(to_ns(t) + shift());
  return result;
}

int gettimeofday(struct timeval* restrict t, void* restrict zone) {
  (void)zone;
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  t->tv_sec = now.tv_sec;
  t->tv_usec = now.tv_nsec / 1000;
  return 0;
}

time_t time(time_t* to) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (to != NULL) *to = now.tv_sec;
  return now.tv_sec;
}

int timespec_get(struct timespec* t, int base) {
  if (base != TIME_UTC) return 0;
  clock_gettime(CLOCK_REALTIME, t);
  return base;
}

/* The following functions wait until an instant of the wall clock. unshifted() counts the wait, and computes
   its end from the current offset. */

static struct timespec unshifted(const struct timespec* until) {
  if (shared != NULL) atomic_fetch_add(&shared->waits, 1);
  return from_ns(to_ns(until) - shift());
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec* t, struct timespec* left) {
  static int (*real)(clockid_t, int, const struct timespec*, struct timespec*);
  if (real == NULL) *(void**)&real = dlsym(RTLD_NEXT, "clock_nanosleep");
  if (clock != CLOCK_REALTIME || (flags & TIMER_ABSTIME) == 0) return real(clock, flags, t, left);
  const struct timespec until = unshifted(t);
  return real(clock, flags, &until, left);
}

int pthread_cond_timedwait(pthread_cond_t* restrict condition, pthread_mutex_t* restrict mutex,
                           const struct timespec* restrict t) {
  const struct timespec until = unshifted(t);
  return pthread_cond_clockwait(condition, mutex, CLOCK_REALTIME, &until);
}

int pthread_mutex_timedlock(pthread_mutex_t* restrict mutex, const struct timespec* restrict t) {
  const struct timespec until = unshifted(t);
  return pthread_mutex_clocklock(mutex, CLOCK_REALTIME, &until);
}

int sem_timedwait(sem_t* restrict semaphore, const struct timespec* restrict t) {
  const struct timespec until = unshifted(t);
  return sem_clockwait(semaphore, CLOCK_REALTIME, &until);
}
