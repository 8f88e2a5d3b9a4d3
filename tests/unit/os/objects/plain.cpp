// A global variable and a function, and nothing of the names that the C library has too.
int counter = 0;
extern "C" int count_up() { return ++counter; }
