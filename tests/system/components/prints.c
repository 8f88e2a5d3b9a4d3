/* Prints on both standard output and standard error: a line before it attaches, a numbered line in each of
 * its first `lines` releases (default 200), then a line of `long` letters (default 100000), and at the end a
 * last line without a line feed. */
#include <takt/process.h>

#include "argument.h"

static void print_long(FILE* out, long length) {
  for (long i = 0; i < length; ++i) fputc('x', out);
  fputc('\n', out);
}

static void say_goodbye(void) {
  printf("out: a partial last line");
  fprintf(stderr, "err: a partial last line");
}

int main(int argc, char* argv[]) {
  const long lines = (long)argument_number(argc, argv, "lines", 200, 0, 1e9);
  const long letters = (long)argument_number(argc, argv, "long", 100000, 0, 1e8);
  printf("out: before it attaches\n");
  fprintf(stderr, "err: before it attaches\n");
  initPeriodExe();
  atexit(say_goodbye);
  for (long line = 1;; ++line) {
    waitPeriod();
    if (line <= lines) {
      printf("out: line %ld\n", line);
      fprintf(stderr, "err: line %ld\n", line);
    } else if (line == lines + 1) {
      print_long(stdout, letters);
      print_long(stderr, letters);
    }
  }
  return 0;
}
