// A bundle: a descriptor and the files that it includes, unchanged, in one text.
//
// A node receives one text and no files, and its messages must name the files and lines that the author
// knows. So a bundle contains the files themselves instead of the expanded descriptor. The descriptor is the
// first of them: <bundle><source file="cell.xml">...</source>...</bundle>.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

struct Source {
  std::string file;
  std::string text;
  model::Line line{};
};

std::string bundle_of(const std::vector<Source>& sources);

/// The sources of a bundle. If the bundle is not valid, reports the problem and returns no sources.
std::vector<Source> sources_of(const Node& bundle, Report& report);

}  // namespace takt::descriptor
