// What a cell looks like in XML: each element, its attributes and its children, in the order of the document.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/validate.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

/// A cell that is as complete as could be read; where something could not, a value stands in that nobody
/// complains about, or a gap.
struct Reading {
  model::Cell cell;
  model::Gaps gaps;
};

/// Reports what cannot be read; what is read and makes no sense is left to model::validate.
Reading read_cell(const Node& root, const std::string& file, Report& report);

/// The name of the cell and the device of a module.xml: the file's stem, with '_' for what a name may not
/// have.
std::string name_after(const std::string& file);

}  // namespace takt::descriptor
