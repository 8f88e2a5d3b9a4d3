#include <takt/os/library.hpp>

#include <cxxabi.h>
#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/os/files.hpp>
#include <takt/os/sealed_copy.hpp>
#include "error.hpp"

namespace takt::os {

namespace {

// Returns the name of a symbol as its author wrote it.
std::string readable(const std::string& symbol) {
  int status = 0;
  const std::unique_ptr<char, void (*)(void*)> name{
      abi::__cxa_demangle(symbol.c_str(), nullptr, nullptr, &status), std::free};
  return name != nullptr ? name.get() : symbol;
}

// Returns the name of a variable that the loader would share between copies of the object; empty if there is
// none. The loader binds a GNU_UNIQUE symbol to one address in the whole process. Such symbols of the C++
// standard library (guards and tags of its templates) are ignored, because they hold no state of the module.
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

// Returns true if the file is shorter than its ELF header says. The loader would not notice, and the process
// would crash.
bool is_cut_off(const Fd& fd) {
  ElfW(Ehdr) header{};
  struct stat status {};
  if (::pread(fd.get(), &header, sizeof header, 0) != sizeof header || ::fstat(fd.get(), &status) != 0 ||
      std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
    return false;
  return header.e_shoff + std::uint64_t{header.e_shnum} * header.e_shentsize >
         static_cast<std::uint64_t>(status.st_size);
}

// Gives the copy a path that no loaded object has. The loader treats objects with the same path as one
// object, and the path contains a descriptor number, which may have been used before. Duplicates `copy` until
// its number is unused.
Result<std::shared_ptr<Fd>> with_unused_path(Fd copy) {
  std::vector<Fd> taken;
  while (true) {
    void* other = ::dlopen(path_of(copy).c_str(), RTLD_LAZY | RTLD_NOLOAD);
    if (other == nullptr) return std::make_shared<Fd>(std::move(copy));
    ::dlclose(other);
    taken.push_back(std::move(copy));
    copy = Fd{::fcntl(taken.back().get(), F_DUPFD_CLOEXEC, 0)};
    if (!copy)
      return errno_problem("cannot duplicate the descriptor for a copy of a module", "free file descriptors");
  }
}

struct Unload {
  void operator()(void* handle) const { ::dlclose(handle); }
};

// Loads the libraries that an object finds in a folder that is relative to its own ($ORIGIN). For the loader,
// a copy of the object has no folder, but the copy finds a library that is loaded by the library's name
// (DT_SONAME).
std::vector<std::unique_ptr<void, Unload>> libraries_beside(const std::string& path,
                                                            const std::string& copy) {
  const std::string folder = std::filesystem::absolute(path).parent_path();
  std::vector<std::string> candidates;
  std::istringstream folders{library_folders(copy)};
  for (std::string place; std::getline(folders, place, ':');) {
    for (const std::string_view origin : {"$ORIGIN", "${ORIGIN}"}) {
      if (!place.starts_with(origin)) continue;
      for (const std::string& name : needed_libraries(copy))
        candidates.push_back(folder + place.substr(origin.size()) + "/" + name);
    }
  }
  std::vector<std::unique_ptr<void, Unload>> libraries;
  // Try again after each success, because one of the libraries may need another one.
  for (bool found = true; found;) {
    found = false;
    std::erase_if(candidates, [&](const std::string& candidate) {
      void* const library = ::dlopen(candidate.c_str(), RTLD_NOW | RTLD_LOCAL);
      if (library == nullptr) return false;
      libraries.emplace_back(library);
      return found = true;
    });
  }
  return libraries;
}

// Gives an object that was loaded from a copy the path of the copied file, so that dladdr(), debuggers and
// core dumps show this path. The loader still finds the object by the path of the copy, and frees the new
// name when it unloads the object.
void rename_object(void* handle, const std::string& copy, const std::string& path) {
  link_map* object = nullptr;
  if (::dlinfo(handle, RTLD_DI_LINKMAP, &object) == 0 && object->l_name == copy)
    std::free(std::exchange(object->l_name, ::strdup(path.c_str())));
}

/// The copies from which objects with shared globals were loaded, by the path of the copied file.
class SharedCopies {
 public:
  Result<std::shared_ptr<Fd>> of(const std::string& path, Fd copy) {
    const std::lock_guard lock{mutex_};
    std::weak_ptr<Fd>& place = copies_[path];
    if (auto loaded = place.lock()) return loaded;
    auto own = with_unused_path(std::move(copy));
    if (own) place = *own;
    return own;
  }
  [[nodiscard]] bool contain(const std::string& path) {
    const std::lock_guard lock{mutex_};
    const auto at = copies_.find(path);
    return at != copies_.end() && !at->second.expired();
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<Fd>> copies_;
};

SharedCopies& shared_copies() {
  static SharedCopies copies;
  return copies;
}

}  // namespace

void* loaded_function(const char* name) noexcept { return ::dlsym(RTLD_DEFAULT, name); }
void* next_function(const char* name) noexcept { return ::dlsym(RTLD_NEXT, name); }

Library::Library(Library&& other) noexcept
    : copy_(std::move(other.copy_)), handle_(std::exchange(other.handle_, nullptr)) {}

Library& Library::operator=(Library&& other) noexcept {
  std::swap(copy_, other.copy_);
  std::swap(handle_, other.handle_);
  return *this;
}

Library::~Library() {
  if (handle_ != nullptr) ::dlclose(handle_);
}

Result<Library> Library::open(const std::string& path, Globals globals, Fd copy, Origin origin) {
  Library library;
  if (!copy) {
    auto copied = sealed_copy(path);
    if (!copied) return copied.problems();
    copy = std::move(*copied);
  }
  if (is_cut_off(copy))
    return fail("cannot load " + path + ": a part of the file is missing", "copy it again");
  std::vector<std::unique_ptr<void, Unload>> beside;  // needed only until the object itself uses them
  if (origin == Origin::searched) beside = libraries_beside(path, path_of(copy));
  if (globals == Globals::own) {
    if (const std::string variable = shared_variable(copy); !variable.empty()) {
      return fail(path +
                      " cannot be loaded with its own globals for a second module: the loader would share "
                      "the variable " +
                      variable,
                  "compile it with -fno-gnu-unique, or make it a takt::Component");
    }
  }
  auto kept =
      globals == Globals::own ? with_unused_path(std::move(copy)) : shared_copies().of(path, std::move(copy));
  if (!kept) return kept.problems();
  library.copy_ = std::move(*kept);
  const std::string file = path_of(*library.copy_);
  library.handle_ = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library.handle_ == nullptr) {
    const char* const text = ::dlerror();
    std::string reason = text != nullptr ? text : "unknown";
    if (reason.starts_with(file + ": ")) reason.erase(0, file.size() + 2);
    constexpr std::string_view kUndefined = "undefined symbol: ";
    if (const std::size_t at = reason.find(kUndefined); at != std::string::npos) {
      const std::string symbol = readable(reason.substr(at + kUndefined.size()));
      return fail("cannot load " + path + ": " + reason.substr(0, at) + std::string{kUndefined} + symbol,
                  "link the library that defines " + symbol);
    }
    return fail("cannot load " + path + ": " + reason, "use a shared object that is built for this machine");
  }
  rename_object(library.handle_, file, std::filesystem::absolute(path));
  return library;
}

bool Library::is_loaded(const std::string& path) { return shared_copies().contain(path); }

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
