// The program takt: parses the command line and runs the chosen command.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include <takt/core/words.hpp>

#include "commands/commands.hpp"
#include "manual/pages.hpp"
#include "signatures.hpp"
#include "terminal/terminal.hpp"

namespace {

int run_program(int argc, char** argv) {
  using namespace takt::tool;
  CLI::App app{"Takt: real-time component middleware for industrial cells.", "takt"};
  app.set_version_flag("--version", TAKT_VERSION);
  app.require_subcommand(1);
  app.footer(R"(
Environment:
  TAKT_COMPONENT_PATH         folders, separated by ':', to search for components: after the descriptor's own
                              folder, before the ready-made components
  TAKT_DOMAIN                 the DDS domain, unless --domain is given
  TAKT_INTERFACE              addresses, separated by ',', of the network interfaces to use (default: all)
  TAKT_SECURITY               the folder of the identity to use (see takt secure), unless --security is given
  TAKT_SIGNED_BY              a certificate: use only components that are signed with its key
  TAKT_STATE_DIR              where takt-node keeps its fault record, and the deployment for --resume
  NO_COLOR                    turns colours off

Exit status: 0 success, 1 rejected or failed, with the reason on standard error, 2 wrong usage.)");

  Chosen chosen;
  for (const auto add : kCommands) add(app, chosen);

  tidy_help(app);
  shorten_errors(app);
  if (argc == 3 && std::string_view{argv[1]} == kWritePages) return write_pages(app, argv[2], 1);

  // `takt help COMMAND` is `takt COMMAND --help`.
  std::vector<char*> words(argv, argv + argc);
  std::string help = "--help";
  if (argc > 1 && std::string_view{argv[1]} == "help") {
    words.erase(words.begin() + 1);
    words.insert(words.begin() + std::min(argc - 1, 2), help.data());
    argv = words.data();
  }

  const std::string_view first = argc > 1 ? argv[1] : "";
  if (first.starts_with("-") && first != "-h" && first != "--help" && first != "--version") {
    std::fprintf(
        stderr,
        "takt: the command must stand before its options, as in takt status --domain 7; %s is not a command\n"
        "takt --help lists all commands\n",
        takt::in_quotes(first).c_str());
    return 2;
  }
  const auto is_meant = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(is_meant).empty()) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) {
      if (!command->get_group().empty()) names.push_back(command->get_name());
    }
    std::string_view meant = takt::nearest(argv[1], {names.begin(), names.end()});
    // A command of which only the beginning was entered is meant, rather than one that is spelled alike.
    const auto begins = [&](const std::string& name) { return name.starts_with(argv[1]); };
    if (std::count_if(names.begin(), names.end(), begins) == 1)
      meant = *std::find_if(names.begin(), names.end(), begins);
    const std::string next =
        meant.empty() ? "takt --help lists all commands" : "did you mean " + std::string{meant} + "?";
    std::fprintf(stderr, "takt: there is no command %s; %s\n", takt::in_quotes(argv[1]).c_str(),
                 next.c_str());
    return 2;
  }
  if (argc > 2 && first[0] != '-' && argv[2][0] != '-') {
    const std::vector<CLI::App*> of_command = app.get_subcommand(argv[1])->get_subcommands({});
    std::string known;
    bool is_known = of_command.empty();
    for (const CLI::App* command : of_command) {
      if (!command->get_group().empty()) known += (known.empty() ? "" : ", ") + command->get_name();
      is_known |= command->get_name() == argv[2];
    }
    if (!is_known) {
      std::fprintf(stderr,
                   "takt %s: there is no command %s; the commands are %s\n"
                   "Usage: takt %s SUBCOMMAND [OPTIONS]\ntakt %s --help explains all commands\n",
                   argv[1], takt::in_quotes(argv[2]).c_str(), known.c_str(), argv[1], argv[1]);
      return 2;
    }
  }
  require_signatures();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return explain(app, error);
  }
  return chosen();
}

}  // namespace

int main(int argc, char** argv) {
  const int status = takt::tool::finish(run_program(argc, argv));
  // End with _Exit to skip the static destructors of Fast DDS, which sleep for a while.
  std::fflush(nullptr);
  std::_Exit(status);
}
