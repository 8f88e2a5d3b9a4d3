#include "bundle.hpp"

#include <set>

#include <takt/core/words.hpp>
#include "element.hpp"
#include "write.hpp"

namespace takt::descriptor {

std::string bundle_of(const std::vector<Source>& sources) {
  std::string text = "<bundle>\n";
  for (const Source& source : sources)
    text += "<source file=\"" + escaped(source.file) + "\">" + escaped(source.text) + "</source>\n";
  return text + "</bundle>\n";
}

std::vector<Source> sources_of(const Node& bundle, Report& report) {
  std::vector<Source> sources;
  std::set<std::string> files;
  const Element element{bundle, {.many = {"source"}}, report};
  for (const Node* child : element.children("source")) {
    const Element source{*child, {.attributes = {"file"}, .text = true}, report};
    const auto file = source.required_attribute("file");
    if (!file || report.full()) continue;
    if (!files.insert(file->text).second)
      report.add(file->line, "duplicate source " + in_quotes(file->text), "list each file once");
    sources.push_back({file->text, source.text(), source.line()});
  }
  if (sources.empty() && report.empty())
    report.add(bundle.line, "the bundle has no <source>", "add the descriptor as the first <source>");
  if (!report.empty()) sources.clear();
  return sources;
}

}  // namespace takt::descriptor
