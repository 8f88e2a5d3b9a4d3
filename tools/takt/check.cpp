#include <cstdio>
#include <fstream>

#include "check_report.hpp"
#include "commands.hpp"
#include "load.hpp"
#include "terminal.hpp"

namespace takt::tool {

int check(const CheckOptions& options) {
  Problems missing;
  const auto loaded = load(options.file, options.remote ? &missing : nullptr);
  for (const Problem& problem : missing) {
    std::fprintf(stderr, "%s: warning: %s; its node will look for it\n", problem.where.c_str(),
                 problem.what.c_str());
  }
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  if (!options.svg.empty()) {
    std::ofstream out{options.svg};
    out << check_svg(loaded->cell, loaded->plans);
    if (!out.flush()) {
      complain({{options.svg, "cannot be written", "name a file in a folder that you may write to"}});
      return 1;
    }
  }
  const std::string text = options.json ? check_json(loaded->cell, loaded->plans).dump() + "\n"
                                        : check_text(loaded->cell, loaded->plans, terminal_style());
  return print(text) ? 0 : 1;
}

}  // namespace takt::tool
