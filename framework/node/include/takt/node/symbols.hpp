// Names places in code (function, source line) from the symbols of the file that it was loaded from.
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

  /// "Servo::run(takt::Cycle const&) at servo.cpp:31 in servo.so", or as much of it as is known. `address` is
  /// relative to the object's file. A file is opened once and stays open.
  std::string name(const std::string& object, std::uint64_t address);

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// "in A, called by B, called by C, ...": the first `most` of these calls, innermost first, without those of
/// the C and C++ libraries. Empty if there is none.
std::string called_by(const std::vector<std::string>& calls, std::size_t most);

}  // namespace takt::node
