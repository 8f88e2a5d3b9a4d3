// A module without condition(). The descriptor declares it sporadic, which is an error.
#include <takt/module.h>

extern "C" {
void initialize(irp::Property const&) {}
void run(void) {}
}
