// takt-host, the real-time process: it runs executors and thread modules of one device. It carries out the
// requests of its node, reports through the channel (the shared memory of the device), and ends when its node
// has ended.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace takt::host {

/// Runs the program takt-host. The environment variables TAKT_NODE_FD, TAKT_CHANNEL_FD and TAKT_FLIGHT_FD
/// give the file descriptors of the socket to the node, of the channel and of the flight record. Returns the
/// exit status.
int run_host();

/// Reports that the calling thread ends this process, and the module in whose code it is, if any. So the node
/// does not look for another cause. takt-host calls it before each call of _exit(). Async-signal-safe.
void report_exit() noexcept;

/// True if the calling thread is in code of a module and `fd` is a file descriptor of the host. Then
/// takt-host leaves the descriptor open, and the hook fails. Async-signal-safe.
bool protects(int fd) noexcept;

/// Throws an exception, by which the hook fails, if the calling thread is a thread of the host and in a hook.
/// takt-host calls it before each call of pthread_exit().
void check_thread_exit();

/// A thread that a module starts itself.
struct ModuleThread {
  void* (*body)(void*);
  void* argument;
  std::uint32_t owner;                   ///< index of the module, plus 1
  std::shared_ptr<const char> instance;  ///< keeps the code of the module in memory, see own_threads.hpp
};
/// If the calling thread is in a hook, or was started by a module, returns the thread that it is about to
/// start. takt-host calls it in pthread_create(), and lets the thread begin with run_thread_of_module(), so
/// that a crash of the thread is attributed to its module. Null if the calling thread is not a module's, or
/// if there is no memory.
std::unique_ptr<ModuleThread> thread_of_module(void* (*body)(void*), void* argument) noexcept;
/// Runs the thread, and then deletes `thread`, a ModuleThread.
void* run_thread_of_module(void* thread);

/// If the calling thread is in a hook, or was started by a module, registers the timer that it is about to
/// create. Each expiry of the timer starts a thread (SIGEV_THREAD), which must call run_timer_of_module()
/// with the returned id. So a crash of `expire` is attributed to the module, and the timer ends when the
/// module is unloaded. Returns 0 if the calling thread is not a module's.
std::uint64_t add_timer_of_module(std::function<void()> expire);
/// The timer has been created. `remove` deletes it.
void timer_of_module_created(std::uint64_t id, const void* handle, std::function<void()> remove);
void timer_of_module_failed(std::uint64_t id);
/// A timer is about to be deleted, which may be one of a module.
void timer_deleted(const void* handle);
/// Calls `expire` of the timer, unless the timer was deleted or its module is being unloaded.
void run_timer_of_module(std::uint64_t id);

}  // namespace takt::host
