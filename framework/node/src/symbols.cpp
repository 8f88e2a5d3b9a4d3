#include <takt/node/symbols.hpp>

#include <cxxabi.h>
#include <dwarf.h>
#include <elfutils/libdw.h>
#include <elfutils/libdwfl.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include <fmt/format.h>

namespace takt::node {

namespace {

// Prevents libdwfl from searching for symbols in other files. Such a search may use the network, and the
// symbols in the file itself suffice.
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

// A line of a source file; empty if it is not known.
struct Line {
  std::string file;
  int number = 0;
};

// True for a header of the system or of Takt. The author of a module needs the line in the module's own code,
// not a line in such a header.
bool is_of_library(const std::string& file) {
  return file.starts_with("/usr/") || file.find("/include/takt/") != std::string::npos;
}

// The line of the call of an inlined function.
Line call_of(Dwarf_Die& inlined, Dwarf_Files* files) {
  Dwarf_Attribute attribute{};
  Dwarf_Word file = 0;
  Dwarf_Word number = 0;
  if (dwarf_formudata(dwarf_attr(&inlined, DW_AT_call_file, &attribute), &file) != 0 ||
      dwarf_formudata(dwarf_attr(&inlined, DW_AT_call_line, &attribute), &number) != 0)
    return {};
  const char* name = dwarf_filesrc(files, file, nullptr, nullptr);
  return {name == nullptr ? "" : name, static_cast<int>(number)};
}

// The line of an address. If this line is in a function of a library that the compiler has inlined, returns
// the line that calls the function.
Line line_of(Dwfl_Module* module, Dwarf_Addr address) {
  Line line;
  Dwfl_Line* const found = dwfl_module_getsrc(module, address);
  if (found == nullptr) return {};
  const char* source = dwfl_lineinfo(found, nullptr, &line.number, nullptr, nullptr, nullptr);
  if (source == nullptr) return {};
  line.file = source;
  Dwarf_Addr bias = 0;
  Dwarf_Die* const unit = dwfl_module_addrdie(module, address, &bias);
  Dwarf_Files* files = nullptr;
  if (!is_of_library(line.file) || unit == nullptr || dwarf_getsrcfiles(unit, &files, nullptr) != 0)
    return line;
  const auto free_scopes = [](Dwarf_Die* scopes) { std::free(scopes); };
  using Scopes = std::unique_ptr<Dwarf_Die, decltype(free_scopes)>;
  Dwarf_Die* all = nullptr;
  if (dwarf_getscopes(unit, address - bias, &all) <= 0) return line;
  const Scopes at{all, free_scopes};
  const int count = dwarf_getscopes_die(at.get(), &all);  // from the innermost inlined function outwards
  if (count <= 0) return line;
  const Scopes scopes{all, free_scopes};
  for (int i = 0; i < count; ++i) {
    Dwarf_Die& scope = scopes.get()[i];
    if (dwarf_tag(&scope) != DW_TAG_inlined_subroutine) continue;
    Line call = call_of(scope, files);
    if (!call.file.empty() && !is_of_library(call.file)) return call;
  }
  return line;
}

bool is_c_library(const std::string& name) {
  return name == "libc.so.6" || name == "libstdc++.so.6" || name == "libgcc_s.so.1";
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
    if (const Line line = line_of(file.module, at); !line.file.empty())
      text += fmt::format(" at {}:{}", last_part(line.file), line.number);
  }
  return text + " in " + last_part(object);
}

std::size_t calls_of_module(const std::vector<std::string>& objects, const std::string& host) {
  const auto of_module = [&host](const std::string& object) {
    return object != host && !is_c_library(last_part(object));
  };
  const auto outermost = std::find_if(objects.rbegin(), objects.rend(), of_module);
  return outermost == objects.rend() ? objects.size() : static_cast<std::size_t>(objects.rend() - outermost);
}

std::string called_by(const std::vector<std::string>& calls, std::size_t most) {
  std::string text;
  std::size_t shown = 0;
  for (const std::string& call : calls) {
    const std::string object = call.substr(call.find_last_of(' ') + 1);
    if (is_c_library(object) || object.starts_with("libtakt_component.so")) continue;
    if (shown++ == most) return text + ", ...";
    text += (text.empty() ? "in " : ", called by ") + call;
  }
  return text;
}

}  // namespace takt::node
