#include <takt/os/environment.hpp>

#include <fcntl.h>
#include <malloc.h>
#include <pwd.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include <takt/core/words.hpp>
#include <takt/os/files.hpp>
#include "error.hpp"

namespace takt::os {

Fd take_fd_from_environment(const char* name) {
  const std::string text = take_from_environment(name);
  int number = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return {};
  return adopt_fd(number);
}

Fd adopt_fd(int number) { return ::fcntl(number, F_SETFD, FD_CLOEXEC) == 0 ? Fd{number} : Fd{}; }

std::string take_from_environment(const char* name) {
  std::string value = environment(name);
  ::unsetenv(name);
  return value;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

void set_environment(const char* name, const std::string& value) { ::setenv(name, value.c_str(), 1); }

ChangedEnvironment::ChangedEnvironment(std::initializer_list<std::string_view> hidden, const char* added)
    : before_(environ) {
  static std::vector<char*> changed;  // another thread may still read it when this object is gone
  changed = {const_cast<char*>(added)};
  for (char** each = environ; *each != nullptr; ++each) {
    const auto names = [each](std::string_view prefix) {
      return std::string_view{*each}.starts_with(prefix);
    };
    if (std::ranges::none_of(hidden, names)) changed.push_back(*each);
  }
  changed.push_back(nullptr);
  environ = changed.data();
}

ChangedEnvironment::~ChangedEnvironment() { environ = before_; }

void share_heaps() noexcept { ::mallopt(M_ARENA_MAX, 2); }

std::vector<std::string> program_arguments() {
  std::ifstream file{"/proc/self/cmdline", std::ios::binary};
  std::vector<std::string> arguments;
  for (std::string one; std::getline(file, one, '\0');) arguments.push_back(one);
  if (!arguments.empty()) arguments.erase(arguments.begin());
  return arguments;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? on_one_line(name.data()) : "localhost";
}

int process_id() { return ::getpid(); }

std::string user_name() { return user_name(::geteuid()); }

std::string user_name(unsigned user) {
  std::array<char, 16384> memory{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(user, &entry, memory.data(), memory.size(), &found) == 0 && found != nullptr)
    return found->pw_name;
  return std::to_string(user);
}

bool is_root() { return ::geteuid() == 0; }

void raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

Result<void> can_open(std::size_t descriptors) {
  std::vector<Fd> opened;
  while (opened.size() < descriptors) {
    opened.emplace_back(::eventfd(0, EFD_CLOEXEC));
    if (opened.back()) continue;
    return errno_problem("this process can open only " + std::to_string(opened.size() - 1) + " of the " +
                         std::to_string(descriptors) + " additional files that it may need");
  }
  return {};
}

std::string boot_id() { return text_of("/proc/sys/kernel/random/boot_id"); }

}  // namespace takt::os
