// A module whose run() fails in the `after`-th cycle (default 100) after the start and after each recovery.
// If `how` is throw, run() throws; if it is fail, run() calls takt_fail(). recover() fails if `recoverable`
// is false.
#include <takt/module.h>

static long long after = 100;
static bool throws = true;
static bool recoverable = true;
static long long runs = 0;

extern "C" {
void initialize(irp::Property const& property) {
  after = property.get("after", 100LL, 1, 1000000000);
  throws = property.get("how", "throw") == "throw";
  recoverable = property.get("recoverable", true);
}
void run(void) {
  if (++runs < after) return;
  if (throws) throw std::runtime_error("run() threw as it was asked to");
  takt_fail("run() failed as it was asked to");
}
void recover(void) {
  if (!recoverable) throw std::runtime_error("recover() threw as it was asked to");
  runs = 0;
}
}
