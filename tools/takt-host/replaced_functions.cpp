// Functions of the C library that takt-host replaces. A component that calls one of them calls the function
// here, because the dynamic loader looks for it first in the program.
#include <thread>

#include <takt/host/host.hpp>
#include <takt/os/library.hpp>
#include <takt/os/system_calls.hpp>

extern "C" {

// Ends this process, and with it all modules of the host.
[[noreturn]] void _exit(int status) {
  takt::host::report_exit();
  takt::os::end_process(status);
}

[[noreturn]] void _Exit(int status) { _exit(status); }

// Starts a thread. The host remembers which module has started it.
int pthread_create(pthread_t* id, const pthread_attr_t* attributes, void* (*body)(void*),
                   void* argument) noexcept {
  static auto* const create =
      reinterpret_cast<decltype(&pthread_create)>(takt::os::next_function("pthread_create"));
  auto thread = takt::host::thread_of_module(body, argument);
  if (!thread) return create(id, attributes, body, argument);
  const int error = create(id, attributes, takt::host::run_thread_of_module, thread.get());
  if (error == 0) static_cast<void>(thread.release());  // the new thread owns it
  return error;
}
}
