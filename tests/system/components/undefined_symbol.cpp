// Calls a function that no library defines.
#include <takt/module.h>

void takt_test_defined_nowhere(int);

extern "C" void run(void) { takt_test_defined_nowhere(1); }
