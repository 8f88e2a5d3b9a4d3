// Overflows its stack in its `after`-th run (default 100).
#include <takt/module.h>

static long long after = 100;
static long long runs = 0;

static int descend(long long depth) {
  volatile char frame[4096];
  frame[0] = static_cast<char>(depth);
  if (depth == 0) return 0;
  return descend(depth - 1) + frame[0];  // reading the frame afterwards prevents a tail call
}

extern "C" {
void initialize(irp::Property const& property) { after = property.get("after", 100LL, 1, 1000000000); }
void run(void) {
  if (++runs == after) descend(1LL << 40);
}
}
