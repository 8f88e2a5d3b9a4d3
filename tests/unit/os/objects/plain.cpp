// A global variable, a function, and a use of the C library, so that the object depends on it; nothing of the
// names that the C library has too.
#include <cstdlib>

int counter = 0;
extern "C" int count_up() { return ++counter; }
extern "C" const char* home() { return std::getenv("HOME"); }
