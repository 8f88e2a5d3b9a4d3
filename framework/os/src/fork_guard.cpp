#include <takt/os/fork_guard.hpp>

#include <sys/mman.h>
#include <unistd.h>

#include "error.hpp"

namespace takt::os {

namespace {

constexpr std::size_t kPage = 4096;
// Points to the value 1, which the kernel sets to 0 in each copy of the process.
const volatile int* mark = nullptr;

}  // namespace

Result<void> guard_against_forks() {
  void* const page = ::mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return errno_problem("mmap of the fork guard", "free memory");
  if (::madvise(page, kPage, MADV_WIPEONFORK) != 0) {
    return errno_problem("madvise MADV_WIPEONFORK", "use Linux 4.14 or later");
  }
  *static_cast<int*>(page) = 1;
  mark = static_cast<const int*>(page);
  return {};
}

bool is_forked_copy() noexcept { return mark != nullptr && *mark == 0; }

void end_forked_copy() noexcept {
  if (is_forked_copy()) ::_exit(1);
}

}  // namespace takt::os
