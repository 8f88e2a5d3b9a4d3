// Finds the function and source line of a code address, with the symbols of the file that contains the code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace takt::node {

class Symbols {
 public:
  Symbols();
  ~Symbols();
  Symbols(Symbols&&) noexcept;
  Symbols& operator=(Symbols&&) noexcept;

  /// Describes a place in code, for example "Servo::run(takt::Cycle const&) at servo.cpp:31 in servo.so";
  /// omits parts that are not known. If the compiler has inlined a function of a library there, the line is
  /// the one that calls this function. `address` is relative to the load address of the file `object`, as in
  /// the symbol table of the file. A file that was opened once stays open.
  std::string name(const std::string& object, std::uint64_t address);

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Returns how many of these calls belong to the module: its own functions, and the functions that they
/// called. The remaining calls are the outermost ones, with which the host called the module. `objects`
/// contains, for each call, the file with the called code, innermost first. A function that the module called
/// may be in the file of the host, too. Returns the number of all calls if none is in a file of a module.
std::size_t calls_of_module(const std::vector<std::string>& objects, const std::string& host);

/// Describes the first `most` of these calls, innermost first, as "in A, called by B, called by C, ...".
/// Omits calls in the C and C++ libraries and in libtakt_component, for example takt_log(): the author of the
/// module needs the line that calls them. Returns an empty text if no other call is in the list.
std::string called_by(const std::vector<std::string>& calls, std::size_t most);

}  // namespace takt::node
