// Functions of the C library that takt-host replaces. A component that calls one of them calls the function
// here, because the dynamic loader looks for it first in the program.
#include <takt/host/host.hpp>
#include <takt/os/system_calls.hpp>

extern "C" {

// Ends this process, and with it all modules of the host.
[[noreturn]] void _exit(int status) {
  takt::host::report_exit();
  takt::os::end_process(status);
}

[[noreturn]] void _Exit(int status) { _exit(status); }
}
