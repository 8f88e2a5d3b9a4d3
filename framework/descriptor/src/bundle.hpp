// A descriptor and the files that it includes as one text, each as it was written.
//
// A node is sent a text and no files, and what it says of that text is to name the files and lines that their
// author knows. So what is sent is not what became of them, but all of them: <bundle><source
// file="cell.xml">...</source>...</bundle>, the descriptor first.
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

/// Nothing where it is none; that is reported.
std::vector<Source> sources_of(const Node& bundle, Report& report);

}  // namespace takt::descriptor
