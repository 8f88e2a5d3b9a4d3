// takt-host, the real-time process: it runs executors and thread modules of one device. It carries out the
// requests of its node, reports through the channel (the shared memory of the device), and ends when its node
// has ended.
#pragma once

#include <cstdint>
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

}  // namespace takt::host
