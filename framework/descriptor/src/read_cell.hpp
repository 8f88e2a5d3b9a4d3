// Reads a cell from its expanded XML tree.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/validate.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

/// The parts of a cell that could be read. Each unreadable part is replaced by a harmless value or marked as
/// a gap, so that no later check reports it again.
struct Reading {
  model::Cell cell;
  model::Gaps gaps;
};

/// Reads a cell, and reports the parts that cannot be read. model::validate() checks the values afterwards.
Reading read_cell(const Node& root, const std::string& file, Report& report);

/// The name that a module.xml gives to its cell and device: the filename without its extension, with '_' in
/// place of each character that a name may not have.
std::string name_after(const std::string& file);

}  // namespace takt::descriptor
