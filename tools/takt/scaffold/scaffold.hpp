// Makes the files of `takt new` from templates. The command itself writes them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool {

struct NewFile {
  std::string name;  ///< path in the new folder
  std::string text;
};

struct NewComponent {
  std::string name;
  model::ModuleType type = model::ModuleType::thread;
  model::Operation operation = model::Operation::periodic;  ///< or sporadic
  bool in_c = false;
};

/// A component with its types, descriptor, tests and README. Fails if the name is not valid in C++, IDL or
/// CMake.
Result<std::vector<NewFile>> new_component(const NewComponent& wanted);
/// A cell of two devices that uses ready-made components.
Result<std::vector<NewFile>> new_cell(const std::string& name);

}  // namespace takt::tool
