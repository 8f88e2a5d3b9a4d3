// One hook writes to address 0. The property `where` names this hook: run, initialize, start, error, recover
// or destruct. run() does so in its `after`-th call (default 100). For error and recover, run() fails in its
// `after`-th call, so that Takt calls these hooks.
#include <takt/module.h>

static std::string where;
static long long after = 100;
static long long runs = 0;
static volatile int* volatile nowhere = nullptr;

static void crash_in(const char* hook) {
  if (where == hook) *nowhere = 1;
}

extern "C" {
void initialize(irp::Property const& property) {
  where = property.get("where", "run");
  after = property.get("after", 100LL, 1, 1000000000);
  crash_in("initialize");
}
void start(void) { crash_in("start"); }
void run(void) {
  if (++runs != after) return;
  crash_in("run");
  if (where == "error" || where == "recover") takt_fail("to reach error() and recover()");
}
void error(int) { crash_in("error"); }
void recover(void) { crash_in("recover"); }
void destruct(void) { crash_in("destruct"); }
}
