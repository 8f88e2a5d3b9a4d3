// Functions of the C library that takt-host replaces. A component that calls one of them calls the function
// here, because the dynamic loader looks for it first in the program.
#include <csignal>
#include <ctime>

#include <cerrno>
#include <cstdint>
#include <thread>

#include <takt/host/host.hpp>
#include <takt/os/library.hpp>
#include <takt/os/system_calls.hpp>

namespace {

template <class Function>
Function* original(Function*, const char* name) {
  return reinterpret_cast<Function*>(takt::os::next_function(name));
}

}  // namespace

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
  static auto* const create = original(&pthread_create, "pthread_create");
  auto thread = takt::host::thread_of_module(body, argument);
  if (!thread) return create(id, attributes, body, argument);
  const int error = create(id, attributes, takt::host::run_thread_of_module, thread.get());
  if (error == 0) static_cast<void>(thread.release());  // the new thread owns it
  return error;
}

// Ends the calling thread, unless it is a thread of the host.
[[noreturn]] void pthread_exit(void* value) {
  static auto* const end = original(&pthread_exit, "pthread_exit");
  takt::host::check_thread_exit();
  end(value);
  __builtin_unreachable();
}

// Creates a timer. The C library runs the function of a SIGEV_THREAD timer on threads that it starts without
// calling pthread_create() above, and does not delete the timer when the function is unloaded.
int timer_create(clockid_t clock, sigevent* event, timer_t* timer) noexcept {
  static auto* const create = original(&timer_create, "timer_create");
  if (event == nullptr || event->sigev_notify != SIGEV_THREAD) return create(clock, event, timer);
  const std::uint64_t id = takt::host::add_timer_of_module(
      [expire = event->sigev_notify_function, value = event->sigev_value] { expire(value); });
  if (id == 0) return create(clock, event, timer);
  sigevent own = *event;
  own.sigev_notify_function = [](sigval value) {
    takt::host::run_timer_of_module(reinterpret_cast<std::uintptr_t>(value.sival_ptr));
  };
  own.sigev_value.sival_ptr = reinterpret_cast<void*>(static_cast<std::uintptr_t>(id));
  const int failed = create(clock, &own, timer);
  if (failed != 0) {
    takt::host::timer_of_module_failed(id);
  } else {
    takt::host::timer_of_module_created(id, *timer, [timer = *timer] { timer_delete(timer); });
  }
  return failed;
}

int timer_delete(timer_t timer) noexcept {
  static auto* const remove = original(&timer_delete, "timer_delete");
  takt::host::timer_deleted(timer);
  return remove(timer);
}

// A module cannot close file descriptors of the host, as libraries try that make a process a daemon.
int close(int fd) {
  static auto* const close_one = original(&close, "close");
  if (!takt::host::protects(fd)) return close_one(fd);
  errno = EBADF;
  return -1;
}

int close_range(unsigned first, unsigned last, int flags) noexcept {
  static auto* const close_all = original(&close_range, "close_range");
  constexpr unsigned kMostProtected = 65536;
  constexpr int kOnlyOnExec = 4;  // CLOSE_RANGE_CLOEXEC
  for (unsigned fd = first; fd <= last && fd < kMostProtected && (flags & kOnlyOnExec) == 0; ++fd) {
    if (!takt::host::protects(static_cast<int>(fd))) continue;
    if (fd > first && close_all(first, fd - 1, flags) != 0) return -1;
    if (fd == last) return 0;
    first = fd + 1;
  }
  return close_all(first, last, flags);
}

void closefrom(int first) noexcept { close_range(first < 0 ? 0 : static_cast<unsigned>(first), ~0U, 0); }

}
