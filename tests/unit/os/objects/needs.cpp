// A shared object that finds a library of its own in its folder.
extern "C" int count_up();

extern "C" int count_beside() { return count_up(); }
