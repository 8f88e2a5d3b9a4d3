// An object with a variable that the loader shares between all copies of the object (STB_GNU_UNIQUE).
inline int shared_count = 0;
extern "C" int count_up() { return ++shared_count; }
