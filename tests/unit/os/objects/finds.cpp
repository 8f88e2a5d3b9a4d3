// A program that finds a library of its own in its folder.
#include <cstdio>

extern "C" int count_up();

int main() { std::printf("counted %d\n", count_up()); }
