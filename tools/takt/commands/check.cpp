#include <takt/client/network.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/doubts.hpp>
#include <takt/model/json.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/output_file.hpp>
#include <takt/schedule/placement.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/proof.hpp"
#include "commands/ranges.hpp"
#include "reports/check_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct CheckOptions {
  std::string file;
  bool json = false;
  std::string svg;        ///< the file for the drawing; if empty, no drawing is made
  bool expanded = false;  ///< only print the descriptor, with includes and templates expanded
  bool remote = false;    ///< warn of components that are not on this machine, but do not fail
  ProofOptions proof;
};

/// Returns a warning for each function of a module in C that may be a misspelt hook.
Problems misspelt_hooks(const Loaded& loaded) {
  Problems warnings;
  for (std::size_t d = 0; d < loaded.paths.size(); ++d) {
    for (std::size_t m = 0; m < loaded.paths[d].size(); ++m) {
      const model::Module& module = loaded.cell.devices[d].modules[m];
      for (const Problem& found : host::misspelt_hooks(loaded.paths[d][m]))
        warnings.push_back(model::problem_at(loaded.cell.texts(), model::line_of_file(module),
                                             "module " + module.name + ": " + found.what, found.fix));
    }
  }
  return warnings;
}

int check(const CheckOptions& options) {
  if (options.expanded) {
    const auto flat = descriptor::flatten(options.file);
    if (!flat) complain(flat.problems());
    return flat && print(*flat) ? 0 : 1;
  }
  Problems missing;
  auto loaded = load(options.file, options.remote ? &missing : nullptr);
  for (Problem& problem : missing) problem.fix = "the node will search for the component";
  warn(missing);
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  const auto domain = client::domain_of({}, &loaded->cell);
  if (!domain) {
    complain(domain.problems());
    return 1;
  }
  loaded->cell.domain = *domain;
  warn(model::doubts(loaded->cell, loaded->ports));
  warn(misspelt_hooks(*loaded));
  std::optional<Proof> proof;
  // Prove the deadlines if the user asks for a proof, or if a proof is possible: every module has a budget.
  if (options.proof.given() || schedule::all_state_budgets(loaded->cell)) {
    auto proved = prove(loaded->cell, loaded->plans, options.proof);
    if (!proved) {
      complain(proved.problems());
      return 1;
    }
    proof = std::move(*proved);
    warn(proof->warnings);
  } else {
    const model::Cpus cpus = os::read_cpus();
    for (const model::Device& device : loaded->cell.devices) {
      for (std::string& text : schedule::missing_cpus(device, cpus))
        warn({{"device " + device.name, std::move(text), ""}});
    }
  }
  if (!options.svg.empty()) {
    if (const auto written = os::write_output(options.svg, check_svg(loaded->cell, loaded->plans)); !written) {
      complain(written.problems());
      return 1;
    }
  }
  const std::string text =
      options.json ? model::json_text(check_json(loaded->cell, loaded->plans, proof)) + "\n"
                   : check_text(loaded->cell, loaded->plans, terminal_style(), proof, loaded->ports);
  const bool printed = print(text);
  if (!proof || proof->missed.empty()) return printed ? 0 : 1;
  complain(proof->missed);
  return 1;
}

}  // namespace

void add_check(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<CheckOptions>();
  auto* command =
      app.add_subcommand("check", "Validate a descriptor and print its tables, without starting anything");
  command->add_option("FILE", options->file, "a cell, or a module.xml")->required();
  command->add_flag("--json", options->json, "print one JSON object");
  command->add_option("--svg", options->svg, "write a drawing of the tables (SVG) to this file")
      ->type_name("OUT")->check(svg_file());
  command->add_flag("--expanded", options->expanded,
                    "print the descriptor with includes and templates expanded, instead of the tables");
  command->add_flag("--remote", options->remote, "only warn of components that are not on this machine");
  command
      ->add_option("--profile", options->proof.profile,
                   "prove each deadline with the run times that takt run --profile wrote")
      ->type_name("FILE");
  command
      ->add_option("--factor", options->proof.factor,
                   "multiply run times (or budgets) by X, from 1 to 1000 (default 1)")
      ->type_name("X")
      ->check(within(1, 1000));
  command
      ->add_option("--cpus", options->proof.cpus,
                   "assume that each device has this many CPUs (default: as many as this machine)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024).description(""));
  command->callback([options, &chosen] { chosen = [options] { return check(*options); }; });
}

}  // namespace takt::tool
