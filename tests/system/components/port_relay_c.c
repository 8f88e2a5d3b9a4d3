/* A thread module in C, or a periodic process module if PROGRAM is defined, that forwards the samples that
 * it reads. */
#include "every_period.h"

#include <samples_c.h>

TAKT_IN_PORT(samples_Count, in);
TAKT_OUT_PORT(samples_Count, out);

static void body(void) {
  samples_Count count;
  while (takt_read(&in, &count)) takt_write(&out, &count);
}
