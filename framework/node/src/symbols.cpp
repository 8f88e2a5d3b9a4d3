#include <takt/node/symbols.hpp>

#include <cxxabi.h>
#include <elfutils/libdwfl.h>

#include <cstdlib>
#include <map>

#include <fmt/format.h>

namespace takt::node {

namespace {

// Prevents a search for symbols in other files. Such a search may use the network, and the symbols in the
// file itself are enough.
int no_other_file(Dwfl_Module*, void**, const char*, Dwarf_Addr, const char*, const char*, GElf_Word,
                  char**) {
  return -1;
}

constexpr Dwfl_Callbacks kCallbacks{.find_elf = nullptr,
                                    .find_debuginfo = no_other_file,
                                    .section_address = dwfl_offline_section_address,
                                    .debuginfo_path = nullptr};

struct EndDwfl {
  void operator()(Dwfl* dwfl) const noexcept { dwfl_end(dwfl); }
};

std::string demangled(const char* name) {
  int status = 0;
  char* text = abi::__cxa_demangle(name, nullptr, nullptr, &status);
  std::string result = text == nullptr ? name : text;
  std::free(text);
  return result;
}

std::string last_part(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

}  // namespace

struct Symbols::Files {
  struct File {
    std::unique_ptr<Dwfl, EndDwfl> dwfl;
    Dwfl_Module* module = nullptr;
    Dwarf_Addr bias = 0;
  };
  std::map<std::string, File> open;

  const File& of(const std::string& path) {
    const auto [at, added] = open.try_emplace(path);
    File& file = at->second;
    if (!added) return file;
    file.dwfl.reset(dwfl_begin(&kCallbacks));
    if (!file.dwfl) return file;
    file.module = dwfl_report_offline(file.dwfl.get(), path.c_str(), path.c_str(), -1);
    dwfl_report_end(file.dwfl.get(), nullptr, nullptr);
    if (file.module != nullptr && dwfl_module_getelf(file.module, &file.bias) == nullptr)
      file.module = nullptr;
    return file;
  }
};

Symbols::Symbols() : files_(std::make_unique<Files>()) {}
Symbols::~Symbols() = default;
Symbols::Symbols(Symbols&&) noexcept = default;
Symbols& Symbols::operator=(Symbols&&) noexcept = default;

std::string Symbols::name(const std::string& object, std::uint64_t address) {
  std::string text = fmt::format("{:#x}", address);
  if (object.empty()) return text;
  const Files::File& file = files_->of(object);
  if (file.module != nullptr) {
    const Dwarf_Addr at = file.bias + address;
    if (const char* symbol = dwfl_module_addrname(file.module, at); symbol != nullptr)
      text = demangled(symbol);
    int line = 0;
    Dwfl_Line* found = dwfl_module_getsrc(file.module, at);
    if (found != nullptr) {
      if (const char* source = dwfl_lineinfo(found, nullptr, &line, nullptr, nullptr, nullptr);
          source != nullptr)
        text += fmt::format(" at {}:{}", last_part(source), line);
    }
  }
  return text + " in " + last_part(object);
}

std::string called_by(const std::vector<std::string>& calls, std::size_t most) {
  std::string text;
  std::size_t shown = 0;
  for (const std::string& call : calls) {
    if (call.ends_with(" in libc.so.6") || call.ends_with(" in libstdc++.so.6")) continue;
    if (shown++ == most) return text + ", ...";
    text += (text.empty() ? "in " : ", called by ") + call;
  }
  return text;
}

}  // namespace takt::node
