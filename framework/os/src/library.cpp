#include <takt/os/library.hpp>

#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>

#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "error.hpp"

namespace takt::os {

namespace {

Result<Fd> copy_of(const std::string& path) {
  Fd from{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  struct stat status {};
  if (!from || ::fstat(from.get(), &status) != 0) return errno_problem(path, "name a file that can be read");
  Fd to{::memfd_create("takt-module", MFD_CLOEXEC)};
  if (!to) return errno_problem("memfd_create for a copy of " + path, "free memory or file descriptors");
  off_t done = 0;
  while (done < status.st_size) {
    if (::sendfile(to.get(), from.get(), &done, static_cast<std::size_t>(status.st_size - done)) <= 0) {
      return errno_problem("copying " + path, "free memory");
    }
  }
  return to;
}

// Returns the name of a symbol that the loader would share between copies of the object; empty if there is
// none. The loader binds a GNU_UNIQUE symbol to one address in the whole process. Symbols of the C++ standard
// library (guards and tags of its templates) are ignored, because they hold no state of the module.
std::string shared_variable(const Fd& fd) {
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) return {};
  const auto size = static_cast<std::size_t>(status.st_size);
  void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd.get(), 0);
  if (mapped == MAP_FAILED) return {};
  const auto* bytes = static_cast<const char*>(mapped);
  std::string found;
  const auto inside = [size](std::uint64_t offset, std::uint64_t length) {
    return offset <= size && length <= size - offset;
  };
  const auto* header = reinterpret_cast<const ElfW(Ehdr)*>(bytes);
  if (inside(0, sizeof *header) && std::memcmp(header->e_ident, ELFMAG, SELFMAG) == 0 &&
      inside(header->e_shoff, std::uint64_t{header->e_shnum} * sizeof(ElfW(Shdr)))) {
    const auto* sections = reinterpret_cast<const ElfW(Shdr)*>(bytes + header->e_shoff);
    for (unsigned s = 0; s < header->e_shnum && found.empty(); ++s) {
      const ElfW(Shdr)& table = sections[s];
      if (table.sh_type != SHT_DYNSYM || table.sh_link >= header->e_shnum) continue;
      const ElfW(Shdr)& names = sections[table.sh_link];
      if (!inside(table.sh_offset, table.sh_size) || !inside(names.sh_offset, names.sh_size)) continue;
      const auto* symbols = reinterpret_cast<const ElfW(Sym)*>(bytes + table.sh_offset);
      for (std::size_t i = 0; i < table.sh_size / sizeof(ElfW(Sym)); ++i) {
        const ElfW(Sym)& symbol = symbols[i];
        if (ELF64_ST_BIND(symbol.st_info) != STB_GNU_UNIQUE || symbol.st_shndx == SHN_UNDEF) continue;
        if (symbol.st_name >= names.sh_size) continue;
        const std::string_view name{bytes + names.sh_offset + symbol.st_name};
        if (name.starts_with("_ZNSt") || name.starts_with("_ZZNSt") || name.starts_with("_ZGVZNSt") ||
            name.starts_with("_ZGVNSt") || name.starts_with("_ZSt") || name.starts_with("_ZZNKSt") ||
            name.starts_with("_ZNKSt")) {
          continue;
        }
        found = name;
        break;
      }
    }
  }
  ::munmap(mapped, size);
  return found;
}

// Returns a path for the copy under which no object is loaded. The loader treats objects with the same path
// as the same object, and descriptor numbers, which are part of the path, are reused.
Result<std::string> unused_path(Fd& copy) {
  std::vector<Fd> taken;
  while (true) {
    const std::string path = "/proc/self/fd/" + std::to_string(copy.get());
    void* other = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_NOLOAD);
    if (other == nullptr) return path;
    ::dlclose(other);
    taken.push_back(std::move(copy));
    copy = Fd{::fcntl(taken.back().get(), F_DUPFD_CLOEXEC, 0)};
    if (!copy)
      return errno_problem("cannot duplicate the descriptor for a copy of a module", "free file descriptors");
  }
}

}  // namespace

void* loaded_function(const char* name) noexcept { return ::dlsym(RTLD_DEFAULT, name); }

Library::Library(Library&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}

Library& Library::operator=(Library&& other) noexcept {
  std::swap(handle_, other.handle_);
  return *this;
}

Library::~Library() {
  if (handle_ != nullptr) ::dlclose(handle_);
}

Result<Library> Library::open(const std::string& path, Globals globals) {
  std::string file = path;
  Fd copy;
  if (globals == Globals::own) {
    auto copied = copy_of(path);
    if (!copied) return copied.problems();
    copy = std::move(*copied);
    if (const std::string variable = shared_variable(copy); !variable.empty()) {
      return fail(path +
                      " cannot be loaded with its own globals for a second module: the loader would share "
                      "the variable " +
                      variable,
                  "compile it with -fno-gnu-unique, or make it a takt::Component");
    }
    auto own = unused_path(copy);
    if (!own) return own.problems();
    file = std::move(*own);
  }
  Library library;
  library.handle_ = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library.handle_ == nullptr) {
    const char* reason = ::dlerror();
    return fail("cannot load " + path + ": " + (reason != nullptr ? reason : "unknown"),
                "name a shared object built for this machine, with every symbol it uses");
  }
  return library;
}

bool Library::is_loaded(const std::string& path) noexcept {
  void* handle = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_NOLOAD);
  if (handle != nullptr) ::dlclose(handle);
  return handle != nullptr;
}

void* Library::own_symbol(const char* name) const noexcept {
  void* address = ::dlsym(handle_, name);
  if (address == nullptr) return nullptr;
  Dl_info where{};
  link_map* owner = nullptr;
  link_map* self = nullptr;
  if (::dladdr1(address, &where, reinterpret_cast<void**>(&owner), RTLD_DL_LINKMAP) == 0) return nullptr;
  if (::dlinfo(handle_, RTLD_DI_LINKMAP, &self) != 0) return nullptr;
  return owner == self ? address : nullptr;
}

}  // namespace takt::os
