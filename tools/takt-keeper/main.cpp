#include <takt/os/keeper.hpp>

int main(int count, char** arguments) { return takt::os::keep(count, arguments); }
