#include <takt/os/core_dump.hpp>

#include <glob.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <ctime>

#include <takt/os/files.hpp>

namespace takt::os {

namespace {

bool dumps_core(int signal) {
  for (const int each :
       {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGQUIT, SIGSYS, SIGTRAP, SIGXCPU, SIGXFSZ}) {
    if (signal == each) return true;
  }
  return false;
}

std::string newest_of(const std::string& pattern) {
  glob_t found{};
  std::string newest;
  timespec time{};
  if (::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    for (std::size_t i = 0; i < found.gl_pathc; ++i) {
      struct stat status {};
      if (::stat(found.gl_pathv[i], &status) != 0 || !S_ISREG(status.st_mode)) continue;
      const bool newer = status.st_mtim.tv_sec != time.tv_sec ? status.st_mtim.tv_sec > time.tv_sec
                                                              : status.st_mtim.tv_nsec > time.tv_nsec;
      if (!newest.empty() && !newer) continue;
      newest = found.gl_pathv[i];
      time = status.st_mtim;
    }
  }
  ::globfree(&found);
  // The maximum age of the file, in s. An older file is not from this crash.
  constexpr std::time_t kJustNow = 10;
  return newest.empty() || ::time(nullptr) - time.tv_sec > kJustNow ? "" : newest;
}

}  // namespace

std::string core_glob(std::string_view pattern, int pid, int signal) {
  std::string glob;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char c = pattern[i];
    if (c == '*' || c == '?' || c == '[' || c == '\\') {
      glob += {'\\', c};
    } else if (c != '%') {
      glob += c;
    } else if (++i == pattern.size()) {
      break;  // the kernel, too, omits a % at the end
    } else if (pattern[i] == 'p' || pattern[i] == 'P') {
      glob += std::to_string(pid);
    } else if (pattern[i] == 's') {
      glob += std::to_string(signal);
    } else {
      glob += pattern[i] == '%' ? '%' : '*';
    }
  }
  return glob;
}

CoreDump find_core_dump(int pid, int signal) {
  if (!dumps_core(signal)) return {};
  const std::string pattern = text_of("/proc/sys/kernel/core_pattern");
  if (!pattern.empty() && pattern[0] == '|') {
    const std::string program = pattern.substr(1, pattern.find(' ') - 1);
    return {"", "core_pattern passes core dumps to " + program};
  }
  rlimit limit{};
  ::getrlimit(RLIMIT_CORE, &limit);
  if (limit.rlim_cur == 0) return {"", "RLIMIT_CORE is 0"};
  std::string glob = core_glob(pattern, pid, signal);
  if (text_of("/proc/sys/kernel/core_uses_pid") == "1" && pattern.find("%p") == std::string::npos)
    glob += "." + std::to_string(pid);
  std::string file = newest_of(glob);
  if (file.empty()) return {"", "the kernel wrote no file that matches core_pattern " + pattern};
  if (file[0] != '/') {
    char folder[4096];
    if (::getcwd(folder, sizeof folder) != nullptr) file = std::string{folder} + "/" + file;
  }
  return {file, ""};
}

}  // namespace takt::os
