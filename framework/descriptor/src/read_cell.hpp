// Reads a cell from its expanded XML tree.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/validate.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

/// A cell as far as it could be read. Each part that could not be read is replaced by a harmless value or
/// marked as a gap, so that no later check reports the part again.
struct Reading {
  model::Cell cell;
  model::Gaps gaps;
};

/// Reads a cell, and reports the parts that cannot be read. Only model::validate() checks the values.
Reading read_cell(const Node& root, const std::string& file, Report& report);

/// Returns the name that the cell and the device of a module.xml get: the filename without its extension,
/// with '_' in place of each character that a name may not have.
std::string name_after(const std::string& file);

}  // namespace takt::descriptor
