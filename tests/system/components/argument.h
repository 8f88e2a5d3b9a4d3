/* Functions for programs that declare no properties and read their arguments, as legacy programs do. Each
 * argument is "name=value". An invalid value ends the program before it attaches, with exit status 1 and a
 * reason on standard error. */
#ifndef TAKT_TESTS_ARGUMENT_H
#define TAKT_TESTS_ARGUMENT_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Returns the text after "name=", or `fallback` if no argument has that name. */
static inline const char* argument_text(int argc, char* argv[], const char* name, const char* fallback) {
  const size_t length = strlen(name);
  for (int i = 1; i < argc; ++i) {
    if (strncmp(argv[i], name, length) == 0 && argv[i][length] == '=') return argv[i] + length + 1;
  }
  return fallback;
}

/* Returns the number after "name=", from min to max inclusive, or `fallback` if no argument has that name. */
static inline double argument_number(int argc, char* argv[], const char* name, double fallback, double min,
                                     double max) {
  const char* text = argument_text(argc, argv, name, NULL);
  if (text == NULL) return fallback;
  char* end = NULL;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(value) || value < min || value > max) {
    fprintf(stderr, "property '%s' cannot be '%s'; it takes a number, %g to %g\n", name, text, min, max);
    exit(1);
  }
  return value;
}

#endif
