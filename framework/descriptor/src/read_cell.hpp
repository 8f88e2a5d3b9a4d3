// Reads a cell from its XML tree: each element with its attributes and its children.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/validate.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

/// The parts of a cell that could be read. A part that could not be read is replaced by a harmless value or
/// marked as a gap, so that no later check reports it.
struct Reading {
  model::Cell cell;
  model::Gaps gaps;
};

/// Reads a cell and reports the parts that cannot be read. model::validate() checks the values later.
Reading read_cell(const Node& root, const std::string& file, Report& report);

/// The name of the cell and the device of a module.xml: the stem of the file, with '_' for characters that a
/// name may not have.
std::string name_after(const std::string& file);

}  // namespace takt::descriptor
