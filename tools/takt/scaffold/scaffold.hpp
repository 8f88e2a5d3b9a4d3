// Makes the contents of the files that `takt new` creates, from templates. The command writes the files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool {

struct NewFile {
  std::string name;  ///< path relative to the new folder
  std::string text;
};

struct NewComponent {
  std::string name;
  model::ModuleType type = model::ModuleType::thread;
  model::Operation operation = model::Operation::periodic;  ///< periodic or sporadic
  bool in_c = false;
};

/// The files of a new component: its source, types, descriptor, tests and README. Fails if the name is not
/// valid in C++, IDL or CMake.
Result<std::vector<NewFile>> new_component(const NewComponent& wanted);
/// The files of a new cell with two devices, which uses ready-made components. Fails if the name is not
/// valid.
Result<std::vector<NewFile>> new_cell(const std::string& name);

}  // namespace takt::tool
