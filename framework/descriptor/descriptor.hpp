// Reads a cell from XML: the paper's module.xml (root element `root`) and the cell form, one model.
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// A larger file is refused before it is parsed.
inline constexpr std::size_t kMaxBytes = std::size_t{16} * 1024 * 1024;

/// Every mistake of the file at once, each with `file:line`: what XML says is wrong, what an element may not
/// have, and what model::validate finds. Nothing is ignored. `file` is named in messages; of a module.xml,
/// cell and device are named after its stem.
Result<model::Cell> parse(std::string_view xml, const std::string& file);

/// parse() of a file's content. Fails too when the file cannot be read. `text`, if given, gets the content.
Result<model::Cell> load(const std::string& file, std::string* text = nullptr);

}  // namespace takt::descriptor
