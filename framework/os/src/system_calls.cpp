#include <takt/os/system_calls.hpp>

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace takt::os {

namespace {

struct Named {
  std::int64_t number;
  const char* name;
};
constexpr auto kNames = std::to_array<Named>({
#include "system_call_names.inc"
});

}  // namespace

std::string system_call_name(std::int64_t number) {
  const auto* found = std::find_if(kNames.begin(), kNames.end(),
                                   [number](const Named& each) { return each.number == number; });
  return found == kNames.end() ? "system call " + std::to_string(number) : found->name;
}

void end_process(int status) noexcept {
  while (true) ::syscall(SYS_exit_group, status);
}

}  // namespace takt::os
