// One hook never returns. The property `where` names this hook: initialize, start, error, recover or
// destruct. For error and recover, run() fails in its `after`-th call (default 100), so that Takt calls these
// hooks.
#include <takt/module.h>

#include <unistd.h>

static std::string where;
static long long after = 100;
static long long runs = 0;

static void hang_in(const char* hook) {
  while (where == hook) pause();
}

extern "C" {
void initialize(irp::Property const& property) {
  where = property.get("where", "initialize");
  after = property.get("after", 100LL, 1, 1000000000);
  hang_in("initialize");
}
void start(void) { hang_in("start"); }
void run(void) {
  if (++runs == after && (where == "error" || where == "recover"))
    takt_fail("to reach error() and recover()");
}
void error(int) { hang_in("error"); }
void recover(void) { hang_in("recover"); }
void destruct(void) { hang_in("destruct"); }
}
