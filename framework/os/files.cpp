#include <takt/os/files.hpp>

#include <elf.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

namespace takt::os {

bool is_executable(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) && ::access(path.c_str(), X_OK) == 0;
}

bool is_shared_object(const std::string& path) {
  std::ifstream file{path, std::ios::binary};
  ElfW(Ehdr) header{};
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_type != ET_DYN) return false;
#if defined(__x86_64__)
  if (header.e_machine != EM_X86_64) return false;
#elif defined(__aarch64__)
  if (header.e_machine != EM_AARCH64) return false;
#endif
  file.seekg(static_cast<std::streamoff>(header.e_phoff));
  for (unsigned i = 0; i < header.e_phnum; ++i) {
    ElfW(Phdr) segment{};
    if (!file.read(reinterpret_cast<char*>(&segment), sizeof segment)) return false;
    if (segment.p_type == PT_INTERP) return false;
  }
  return true;
}

bool output_is_terminal() { return ::isatty(STDOUT_FILENO) == 1; }

}  // namespace takt::os
