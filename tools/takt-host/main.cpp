#include <takt/host/host.hpp>

int main() { return takt::host::run_host(); }
