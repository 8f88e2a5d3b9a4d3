#include <cstdio>
#include <fstream>

#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>

#include "check_report.hpp"
#include "commands.hpp"
#include "load.hpp"
#include "network.hpp"
#include "terminal.hpp"

namespace takt::tool {

int check(const CheckOptions& options) {
  if (options.expanded) {
    const auto flat = descriptor::flatten(options.file);
    if (!flat) complain(flat.problems());
    return flat && print(*flat) ? 0 : 1;
  }
  Problems missing;
  auto loaded = load(options.file, options.remote ? &missing : nullptr);
  for (const Problem& problem : missing) {
    std::fprintf(stderr, "%s: warning: %s; its node will look for it\n", problem.where.c_str(),
                 problem.what.c_str());
  }
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  const auto domain = domain_of({}, &loaded->cell);
  if (!domain) {
    complain(domain.problems());
    return 1;
  }
  loaded->cell.domain = *domain;
  std::optional<Proof> proof;
  // Without being asked, where the descriptor says all that it takes.
  if (options.proof.given() || schedule::all_state_budgets(loaded->cell)) {
    auto proved = prove(loaded->cell, loaded->plans, options.proof);
    if (!proved) {
      complain(proved.problems());
      return 1;
    }
    proof = std::move(*proved);
    for (const Problem& problem : proof->warnings)
      std::fprintf(stderr, "%s: warning: %s\n", problem.where.c_str(), problem.what.c_str());
  }
  if (!options.svg.empty()) {
    std::ofstream out{options.svg};
    out << check_svg(loaded->cell, loaded->plans);
    if (!out.flush()) {
      complain({{options.svg, "cannot be written", "name a file in a folder that you may write to"}});
      return 1;
    }
  }
  const std::string text = options.json
                               ? model::json_text(check_json(loaded->cell, loaded->plans, proof)) + "\n"
                               : check_text(loaded->cell, loaded->plans, terminal_style(), proof);
  const bool printed = print(text);
  if (!proof || proof->missed.empty()) return printed ? 0 : 1;
  std::fflush(stdout);  // the table before what is said of it
  complain(proof->missed);
  return 1;
}

}  // namespace takt::tool
