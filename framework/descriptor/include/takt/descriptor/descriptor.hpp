// Reads a cell from XML. The root element is `root` in the paper's module.xml, and `cell` in Takt's own form.
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// The maximum size in bytes of a descriptor together with all files that it includes. A larger file is
/// rejected before it is parsed.
inline constexpr std::size_t kMaxBytes = std::size_t{16} * 1024 * 1024;

/// Returns the cell. If the text has mistakes, fails and reports all of them, each with `file:line`: invalid
/// XML, elements and attributes that are not allowed, and the problems that model::validate() finds. No part
/// of the text is ignored. `file` is the name for messages; the cell and the device of a module.xml are named
/// after it. parse() opens no file: if the descriptor includes other files, `xml` must be a bundle that
/// contains them.
Result<model::Cell> parse(std::string_view xml, const std::string& file);

/// Like parse(), but reads a file and the files that it includes. Also fails if one of them cannot be read.
/// If `text` is not null, sets it to the text to send to another machine: the content of the file or, if it
/// includes others, a bundle.
Result<model::Cell> load(const std::string& file, std::string* text = nullptr);

/// Returns the text of a descriptor file with its includes and templates expanded.
Result<std::string> flatten(const std::string& file);

}  // namespace takt::descriptor
