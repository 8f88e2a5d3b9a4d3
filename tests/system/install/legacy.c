/* A typical legacy program: works about every millisecond, and at its end prints how much its periods differed from 1 ms. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static long began[100000]; /* us */
static int count;

static int by_size(const void* a, const void* b) { return (*(const long*)a > *(const long*)b) - (*(const long*)a < *(const long*)b); }

static void report(void) {
  int n = 0;
  for (int i = 101; i < count; ++i) began[n++] = labs(began[i] - began[i - 1] - 1000); /* the first hundred are the warm-up */
  if (n == 0) return;
  qsort(began, n, sizeof *began, by_size);
  printf("period of 1000 us off by: median %ld us, p99 %ld us, most %ld us, in %d periods\n", began[n / 2], began[n * 99 / 100],
         began[n - 1], n);
}

static void leave(int signal) {
  (void)signal;
  exit(0);
}

int main(void) {
  atexit(report);
  signal(SIGTERM, leave);
  while (1) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (count < 100000) began[count++] = now.tv_sec * 1000000 + now.tv_nsec / 1000;
    usleep(1000);
  }
}
