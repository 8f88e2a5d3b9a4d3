// A module whose `after`-th run (100) never returns.
#include <takt/module.h>

static long long after = 100;
static long long runs = 0;
static volatile bool for_ever = true;

extern "C" {
void initialize(irp::Property const& property) { after = property.get("after", 100LL, 1, 1000000000); }
void run(void) {
  if (++runs != after) return;
  while (for_ever) {
  }
}
}
