/* A C module with functions whose names are almost those of hooks. */
#include <takt/module.h>

void initialise(void) {}
void Start(void) {}
int condtion(void) { return 1; }
void run(void) {}
