/* A module without properties needs no C++: <takt/module.h> is also a C header. */
#include <takt/module.h>

static int runs = 0;

void initialize(void) { runs = 0; }
void run(void) {
  if (++runs == 1000) takt_fail("1000 runs are done");
}
int condition(void) { return runs < 1000 ? TRUE : FALSE; }
