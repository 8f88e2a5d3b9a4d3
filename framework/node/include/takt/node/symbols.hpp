// Names for places in code, from the files that it was loaded from.
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

  /// "Servo::run(takt::Cycle const&) at servo.cpp:31 in servo.so"; less where less is known. `address` is as
  /// the object's file counts it. A file is opened once and stays open.
  std::string name(const std::string& object, std::uint64_t address);

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// "in A, called by B, called by C, ...": of these calls the first `most`, innermost first, those of the C
/// and C++ libraries left out. Empty where there is none.
std::string called_by(const std::vector<std::string>& calls, std::size_t most);

}  // namespace takt::node
