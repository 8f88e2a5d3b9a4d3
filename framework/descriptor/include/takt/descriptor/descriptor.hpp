// Reads a cell from XML, either the paper's module.xml (root element `root`) or the cell form (`cell`).
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// The maximum size of a descriptor including all files that it includes, in bytes. A larger file is rejected
/// before it is parsed.
inline constexpr std::size_t kMaxBytes = std::size_t{16} * 1024 * 1024;

/// Returns the cell, or all mistakes of the text at once, each with `file:line`: faults of the XML, elements
/// and attributes that are not allowed, and the problems that model::validate() finds. No part of the text is
/// ignored. `file` is the name for messages; the cell and the device of a module.xml are named after its
/// stem. parse() opens no file: if the descriptor includes others, `xml` must be a bundle that contains them.
Result<model::Cell> parse(std::string_view xml, const std::string& file);

/// Like parse(), but reads the text from a file and from the files that it includes. Also fails if one of
/// these files cannot be read. Sets `text`, if given, to the text for another machine: the content of the
/// file, or a bundle.
Result<model::Cell> load(const std::string& file, std::string* text = nullptr);

/// The descriptor that load() reads, with its includes and templates expanded.
Result<std::string> flatten(const std::string& file);

}  // namespace takt::descriptor
