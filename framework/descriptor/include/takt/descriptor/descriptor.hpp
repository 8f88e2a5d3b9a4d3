// Reads a cell from the XML text of a descriptor. The root element is `root` in the paper's module.xml, and
// `cell` in Takt's own form.
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::descriptor {

/// The maximum size in bytes of a descriptor together with all files that it includes. A larger descriptor is
/// rejected before it is parsed.
inline constexpr std::size_t kMaxBytes = std::size_t{16} * 1024 * 1024;

/// Returns the cell. If the text has mistakes, fails and reports all of them, each with `file:line`: invalid
/// XML, elements and attributes that are not allowed, and the problems that model::validate() finds. No part
/// of the text is ignored. Messages use `file` as the name of the text; the cell and the device of a
/// module.xml are named after this file. parse() opens no file: if the descriptor includes other files, `xml`
/// must be a bundle that contains them.
Result<model::Cell> parse(std::string_view xml, const std::string& file);

/// Reads the cell from a file and the files that it includes; see parse(). Also fails if one of the files
/// cannot be read. If `text` is not null, sets `*text` to the text that another machine needs to read the
/// same cell: the content of the file or, if the file includes others, a bundle. If elements or values have
/// mistakes and `rejected` is not null, sets `*rejected` to the part of the cell that could be read.
Result<model::Cell> load(const std::string& file, std::string* text = nullptr,
                         model::Cell* rejected = nullptr);

/// Returns the text of a descriptor with its includes and templates expanded.
Result<std::string> flatten(const std::string& file);

}  // namespace takt::descriptor
