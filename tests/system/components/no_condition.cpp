// A module without condition(), which a descriptor declares sporadic.
#include <takt/module.h>

extern "C" {
void initialize(irp::Property const&) {}
void run(void) {}
}
