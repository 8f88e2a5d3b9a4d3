// Calls a function that no library defines.
#include <takt/module.h>

extern "C" {
void takt_test_defined_nowhere(void);
void run(void) { takt_test_defined_nowhere(); }
}
