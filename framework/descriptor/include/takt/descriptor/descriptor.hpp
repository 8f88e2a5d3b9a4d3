// Reads a cell from XML: the paper's module.xml (root element `root`) and the cell form, one model.
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// A larger file is refused before it is parsed; so is a descriptor that is larger with all that it includes.
inline constexpr std::size_t kMaxBytes = std::size_t{16} * 1024 * 1024;

/// Every mistake of the file at once, each with `file:line`: what XML says is wrong, what an element may not
/// have, and what model::validate finds. Nothing is ignored. `file` is named in messages; of a module.xml,
/// cell and device are named after its stem. No file is opened: what the descriptor includes is found in the
/// bundle that `xml` then is, with names of its own, or not at all.
Result<model::Cell> parse(std::string_view xml, const std::string& file);

/// parse() of a file's content and of the files that it includes. Fails too when one cannot be read. `text`,
/// if given, gets all that another machine needs: the content, or a bundle.
Result<model::Cell> load(const std::string& file, std::string* text = nullptr);

/// What load() reads, as one descriptor without includes and templates.
Result<std::string> flatten(const std::string& file);

}  // namespace takt::descriptor
