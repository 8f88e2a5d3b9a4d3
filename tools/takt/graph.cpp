#include <fstream>

#include <takt/descriptor/descriptor.hpp>

#include "commands.hpp"
#include "graph_report.hpp"
#include "load.hpp"
#include "terminal.hpp"

namespace takt::tool {

int graph(const GraphOptions& options) {
  // Not load(): what the cell looks like needs no component, and a table that does not fit is drawn as well.
  const auto cell = descriptor::load(options.file);
  if (!cell) {
    complain(cell.problems());
    return 1;
  }
  const CellHealth health;
  if (!options.svg.empty()) {
    std::ofstream out{options.svg};
    out << graph_svg(*cell, health);
    if (!out.flush()) {
      complain({{options.svg, "cannot be written", "name a file in a folder that you may write to"}});
      return 1;
    }
    if (!options.json) return 0;
  }
  const std::string text =
      options.json ? graph_json(*cell, health).dump() + "\n" : graph_text(*cell, health, terminal_style());
  return print(text) ? 0 : 1;
}

}  // namespace takt::tool
