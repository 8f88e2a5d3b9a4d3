// Named in a descriptor as sporadic, it lacks condition().
#include <takt/module.h>

extern "C" {
void initialize(irp::Property const&) {}
void run(void) {}
}
