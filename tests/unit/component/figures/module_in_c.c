/* A module without a property of its own needs no C++: <takt/module.h> is C too. */
#include <takt/module.h>

static int runs = 0;

void initialize(void) { runs = 0; }
void run(void) {
  if (++runs == 1000) takt_fail("a thousand is enough");
}
int condition(void) { return runs < 1000 ? TRUE : FALSE; }
