/* A periodic program that waits with the wrong function or, with the argument "thread", in the wrong thread. */
#include <pthread.h>
#include <string.h>
#include <takt/process.h>

static void* body(void* unused) {
  for (int i = 0; i < 1000; ++i) waitPeriod();
  return unused;
}

int main(int argc, char* argv[]) {
  initPeriodExe();
  if (argc > 1 && strcmp(argv[1], "thread") == 0) {
    pthread_t thread;
    pthread_create(&thread, NULL, body, NULL);
    pthread_join(thread, NULL);
  }
  while (1) waitSporadic();
}
