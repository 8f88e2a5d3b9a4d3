// A module whose start() fails. The property `how` says how: throw; fail (return a failure); other (throw
// something that is not a std::exception).
#include <takt/module.h>

static void fail(const std::string& how) {
  if (how == "other") throw 42;
  if (how == "throw") throw std::runtime_error("start() threw as it was asked to");
  takt_fail("start() failed as it was asked to");
}

static std::string how;

extern "C" {
void initialize(irp::Property const& property) { how = property.get("how", "throw"); }
void start(void) { fail(how); }
void run(void) {}
}
