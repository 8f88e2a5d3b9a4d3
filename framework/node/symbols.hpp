// Names for places in code, from the files that it was loaded from.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

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

}  // namespace takt::node
