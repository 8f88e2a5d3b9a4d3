// A module whose initialize() fails. The property `how` says how: throw; fail (return a failure); other
// (throw something that is not a std::exception).
#include <takt/module.h>

static void fail(const std::string& how) {
  if (how == "other") throw 42;
  if (how == "throw") throw std::runtime_error("initialize() threw as it was asked to");
  takt_fail("initialize() failed as it was asked to");
}

extern "C" {
void initialize(irp::Property const& property) { fail(property.get("how", "throw")); }
void run(void) {}
}
