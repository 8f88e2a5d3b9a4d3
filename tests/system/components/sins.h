/* Functions that each do something that real-time code must not do. Their names appear in the backtrace. */
#ifndef TAKT_TESTS_SINS_H
#define TAKT_TESTS_SINS_H

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { SIN_PAGES = 64 };
static char* sin_pages;
static long sin_next_page;
static pthread_mutex_t sin_mutex = PTHREAD_MUTEX_INITIALIZER;

/* Prepares memory that causes page faults on its first use, even if all memory is locked. Call this function
 * before the other functions. */
static void sins_prepare(void) {
  const size_t size = SIN_PAGES * 4096UL;
  sin_pages = (char*)mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  munlock(sin_pages, size);
  madvise(sin_pages, size, MADV_DONTNEED);
}

__attribute__((noinline)) static void sin_allocate(void) {
  void* volatile block = malloc(100);
  free(block);
}
__attribute__((noinline)) static void sin_lock(void) {
  pthread_mutex_lock(&sin_mutex);
  pthread_mutex_unlock(&sin_mutex);
}
__attribute__((noinline)) static void sin_sleep(void) {
  const struct timespec moment = {0, 1000};
  nanosleep(&moment, NULL);
}
__attribute__((noinline)) static void sin_print(void) {
  printf("something\n");
  fflush(stdout);
}
__attribute__((noinline)) static void sin_fault(void) {
  ((volatile char*)sin_pages)[sin_next_page++ % SIN_PAGES * 4096] = 1;
}
/* Makes the system call without the C library. */
__attribute__((noinline)) static void sin_call(void) {
#if defined(__x86_64__)
  long result = SYS_getppid;
  __asm__ volatile("syscall" : "+a"(result) : : "rcx", "r11", "memory");
#else
  syscall(SYS_getppid);
#endif
}

static inline void sin_by_name(const char* name) {
  if (strcmp(name, "allocate") == 0) sin_allocate();
  if (strcmp(name, "lock") == 0) sin_lock();
  if (strcmp(name, "sleep") == 0) sin_sleep();
  if (strcmp(name, "print") == 0) sin_print();
  if (strcmp(name, "fault") == 0) sin_fault();
  if (strcmp(name, "call") == 0) sin_call();
}

#endif
