// Finds the function and source line of places in code, from the symbols of the file that contains the code.
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

  /// Describes a place in code, such as "Servo::run(takt::Cycle const&) at servo.cpp:31 in servo.so", as far
  /// as it is known. `address` is relative to the object's file. A file is opened once and stays open.
  std::string name(const std::string& object, std::uint64_t address);

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// Describes the first `most` of these calls, innermost first, as "in A, called by B, called by C, ...".
/// Leaves out calls in the C and C++ libraries. Empty if no call is left.
std::string called_by(const std::vector<std::string>& calls, std::size_t most);

}  // namespace takt::node
