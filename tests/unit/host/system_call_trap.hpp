// Records every system call of one thread. A seccomp filter reports each call to a second thread, which
// records the call and lets it continue.
#pragma once

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <takt/os/real_time.hpp>

namespace takt::host {

struct SystemCall {
  int number = 0;
  std::array<std::uint64_t, 6> arguments{};
  std::uint64_t stamp = 0;  ///< the value that `stamp` returned while the thread was stopped in the call
};

class SystemCallTrap {
 public:
  /// For each system call, the recording thread calls `stamp` and stores the result with the call.
  explicit SystemCallTrap(std::function<std::uint64_t()> stamp = [] { return std::uint64_t{0}; })
      : calls_(kRoom), stamp_(std::move(stamp)) {
    auto started = os::Thread::start(
        {.name = "trap", .priority = 90}, [this] { watch(); }, nullptr);
    TAKT_CHECK(started.ok());
    watcher_ = std::move(*started);
  }
  ~SystemCallTrap() {
    end_ = true;
    watcher_.join();
    if (const int fd = listener_.load(); fd >= 0) ::close(fd);
  }

  /// Starts recording the system calls of the thread that calls arm(). Recording cannot be stopped, and this
  /// thread must end before the trap is destroyed. Returns 0, or the error number from the kernel.
  int arm() noexcept {
    constexpr auto kNumber = static_cast<std::uint32_t>(offsetof(seccomp_data, nr));
    std::array<sock_filter, 5> program{{
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kNumber),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_rt_sigreturn, 2, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_USER_NOTIF),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    }};
    const sock_fprog filter{.len = static_cast<unsigned short>(program.size()), .filter = program.data()};
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return errno;
    const long fd =
        ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_NEW_LISTENER, &filter);
    if (fd < 0) return errno;
    listener_.store(static_cast<int>(fd));
    return 0;
  }

  /// Returns the system calls recorded so far.
  [[nodiscard]] std::vector<SystemCall> calls() const {
    return {calls_.begin(),
            calls_.begin() + static_cast<std::ptrdiff_t>(count_.load(std::memory_order_acquire))};
  }

 private:
  static constexpr std::size_t kRoom = 100'000;

  void watch() {
    while (!end_) {
      pollfd wanted{.fd = listener_.load(), .events = POLLIN, .revents = 0};
      if (::poll(&wanted, 1, wanted.fd < 0 ? 1 : 20) <= 0 || (wanted.revents & POLLIN) == 0) {
        if ((wanted.revents & POLLHUP) != 0) return;  // the watched thread has ended
        continue;
      }
      seccomp_notif notice{};
      if (::ioctl(wanted.fd, SECCOMP_IOCTL_NOTIF_RECV, &notice) != 0) continue;
      if (const std::size_t n = count_.load(std::memory_order_relaxed); n < kRoom) {
        SystemCall& call = calls_[n];
        call.number = notice.data.nr;
        for (std::size_t i = 0; i < 6; ++i) call.arguments[i] = notice.data.args[i];
        call.stamp = stamp_();
        count_.store(n + 1, std::memory_order_release);
      }
      seccomp_notif_resp go_on{
          .id = notice.id, .val = 0, .error = 0, .flags = SECCOMP_USER_NOTIF_FLAG_CONTINUE};
      ::ioctl(wanted.fd, SECCOMP_IOCTL_NOTIF_SEND, &go_on);
    }
  }

  std::vector<SystemCall> calls_;
  std::function<std::uint64_t()> stamp_;
  std::atomic<std::size_t> count_{0};
  std::atomic<int> listener_{-1};
  std::atomic<bool> end_{false};
  os::Thread watcher_;
};

}  // namespace takt::host
