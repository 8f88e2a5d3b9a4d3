// Calls exit(3) in its `after`-th run (default 100), which ends its host.
#include <takt/module.h>

#include <cstdlib>

static long long after = 100;
static long long runs = 0;

extern "C" {
void initialize(irp::Property const& property) { after = property.get("after", 100LL, 1, 1000000000); }
void run(void) {
  if (++runs == after) std::exit(3);
}
}
