// A bundle: one text that contains a descriptor and the files that it includes, unchanged.
//
// A node receives one text instead of files, but its messages must cite the files and lines that the author
// wrote. So a bundle contains the files themselves and not the expanded descriptor. The first source of a
// bundle is the descriptor: <bundle><source file="cell.xml">...</source>...</bundle>.
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

/// Returns the sources of a bundle. If the bundle is not valid, reports the problem and returns no sources.
std::vector<Source> sources_of(const Node& bundle, Report& report);

}  // namespace takt::descriptor
