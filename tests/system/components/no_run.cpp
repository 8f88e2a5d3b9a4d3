// A thread module without run().
#include <takt/module.h>

extern "C" {
void initialize(irp::Property const&) {}
void start(void) {}
int condition(void) { return TRUE; }
}
