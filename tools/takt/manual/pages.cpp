#include "manual/pages.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <takt/core/words.hpp>

#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using OptionList = std::vector<const CLI::Option*>;

/// True if --help shows this option.
bool is_shown(const CLI::Option* option) { return !option->get_group().empty(); }

OptionList positionals_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* o) { return o->get_positional() && is_shown(o); });
}
OptionList options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* o) { return !o->get_positional() && is_shown(o); });
}
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); });
}

bool takes_value(const CLI::Option* option) { return option->get_items_expected_max() > 0; }

std::vector<std::string> names_of(const CLI::Option* option) {
  std::vector<std::string> names;
  for (const auto& name : option->get_snames()) names.push_back("-" + name);
  for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// ---- The manual pages, in roff

std::string escaped(std::string_view text) {
  std::string roff;
  for (const char c : text) {
    if (c == '\\')
      roff += "\\e";
    else if (c == '-')
      roff += "\\-";
    else if (c == '\'')
      roff += "\\(aq";
    else if (c == '`')
      roff += "\\(ga";
    else
      roff += c;
  }
  return roff;
}

/// A line of text in roff. A leading dot is escaped, because roff treats a line that begins with a dot as a
/// request.
std::string line(std::string_view text) {
  const bool request = text.starts_with(".");
  return (request ? "\\&" : "") + escaped(text) + "\n";
}

std::string bold(std::string_view text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string synopsis(const std::string& name, const CLI::App& app) {
  std::string roff = ".B " + escaped(name) + "\n";
  if (!options_of(app).empty()) roff += "[\\fIOPTION\\fR ...]\n";
  if (!commands_of(app).empty()) roff += "\\fICOMMAND\\fR [\\fIARGUMENT\\fR ...]\n";
  for (const auto* p : positionals_of(app)) {
    const std::string argument = italic(p->get_name(true));
    roff += (p->get_required() ? argument : "[" + argument + "]") + "\n";
  }
  return roff;
}

std::string option_items(const OptionList& options) {
  std::string roff;
  for (const auto* option : options) {
    roff += ".TP\n";
    if (option->get_positional()) {
      roff += italic(option->get_name(true)) + "\n";
    } else {
      std::string names;
      for (const std::string& name : names_of(option)) names += (names.empty() ? "" : ", ") + bold(name);
      if (takes_value(option)) names += " " + italic(option->get_type_name());
      roff += names + "\n";
    }
    std::string text = option->get_description();
    if (!option->get_positional() && option->get_required()) text += " (required)";
    roff += line(text);
  }
  return roff;
}

/// The footer of --help in roff, with the same line breaks.
std::string footer_of(const CLI::App& app) {
  std::string text = app.get_footer();
  while (!text.empty() && text.front() == '\n') text.erase(0, 1);
  if (text.empty()) return "";
  std::string roff = ".nf\n";
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    roff += end == begin ? std::string{".sp\n"} : line(std::string_view{text}.substr(begin, end - begin));
    begin = end + 1;
  }
  return roff + ".fi\n";
}

std::string upper(std::string text) {
  for (char& c : text) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return text;
}

// ---- The completion script for bash

/// Returns how bash completes a value of this type: "files", "folders", the argument of `takt complete` that
/// prints the possible values (such as "devices"), both ("devices+files"), or "-" for no completion.
std::string completed(const std::string& value) {
  if (value == "FILE" || value == "OUT") return "files";
  if (value == "DIR") return "folders";
  if (value == "D") return "devices";
  if (value == "DEVICE|FILE") return "devices+files";
  if (value == "TARGET") return "targets";
  if (value == "MODULE") return "modules";
  if (value == "PORT") return "ports";
  if (value == "SERVICE") return "services";
  if (value == "PROPERTY") return "properties";
  return "-";
}

/// Adds the cases of a command and its subcommands to the script. `path` names the command, for example "",
/// "run" or "bench table1".
void add_cases(const CLI::App& app, const std::string& path, std::string* values, std::string* words) {
  std::string names;
  for (const auto* option : options_of(app)) {
    std::string pattern;
    for (const std::string& name : names_of(option)) {
      names += (names.empty() ? "" : " ") + name;
      pattern += (pattern.empty() ? "'" : "|'") + path + ":" + name + "'";
    }
    if (takes_value(option))
      *values += "    " + pattern + ") kind=" + completed(option->get_type_name()) + "; value=1 ;;\n";
  }
  std::string inner;
  for (const auto* command : commands_of(app)) inner += (inner.empty() ? "" : " ") + command->get_name();
  std::string kinds;
  for (const auto* p : positionals_of(app))
    kinds += (kinds.empty() ? "" : " ") + completed(p->get_name(true));
  *words +=
      "    '" + path + "') options='" + names + "'; commands='" + inner + "'; kinds=(" + kinds + ") ;;\n";
  for (const auto* command : commands_of(app))
    add_cases(*command, path.empty() ? command->get_name() : path + " " + command->get_name(), values, words);
}

constexpr std::string_view kBash = R"(# bash completion for @NAME@, generated by its build.
_@FUNCTION@() {
  local cur=${COMP_WORDS[COMP_CWORD]} path='' options='' commands='' kind='' value='' word i
  local -a kinds=() arguments=() network=()
  COMPREPLY=()
  # Find the command: follow the words that name a command or subcommand. The other words are its arguments.
  for ((i = 1; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    _@FUNCTION@_words "$path"
    if [[ ${#arguments[@]} == 0 && " $commands " == *" $word "* ]]; then
      path=${path:+$path }$word
    elif [[ $word == -* ]]; then
      _@FUNCTION@_value "$path:$word"
      [[ -z $value ]] && continue
      case $word in --domain|--peers|--server|--security) network+=("$word" "${COMP_WORDS[i+1]}") ;; esac
      i=$((i + 1))
    else
      arguments+=("$word")
    fi
  done
  _@FUNCTION@_words "$path"
  _@FUNCTION@_value "$path:${COMP_WORDS[COMP_CWORD-1]}"
  if [[ -z $value ]]; then
    if [[ $cur == -* ]]; then
      COMPREPLY=($(compgen -W "$options" -- "$cur"))
      return
    fi
    COMPREPLY=($(compgen -W "$commands" -- "$cur"))
    # A further argument is of the kind of the last one, because an argument may be repeated.
    i=${#arguments[@]}
    ((i >= ${#kinds[@]})) && i=$((${#kinds[@]} - 1))
    ((i >= 0)) && kind=${kinds[i]}
  fi
  local IFS=$'\n'
  case $kind in
    *files) COMPREPLY+=($(compgen -f -- "$cur")) ;;
    folders) COMPREPLY+=($(compgen -d -- "$cur")) ;;
  esac
  case $kind in
    *files|folders) compopt -o filenames 2>/dev/null ;;
  esac
  case $kind in
    devices*|targets|modules|ports|services|properties)
      while read -r word; do
        [[ $word == "$cur"* ]] && COMPREPLY+=("$word")
      done < <("${COMP_WORDS[0]}" complete "${kind%+files}" "$cur" "${arguments[@]:0:1}" "${network[@]}" 2>/dev/null)
      ;;
  esac
  return 0
}
_@FUNCTION@_value() {
  value='' kind=''
  case $1 in
@VALUES@  esac
}
_@FUNCTION@_words() {
  case $1 in
@WORDS@  esac
}
complete -F _@FUNCTION@ @NAME@
)";

void replace(std::string* text, std::string_view from, std::string_view to) {
  for (std::size_t at = text->find(from); at != std::string::npos; at = text->find(from, at + to.size()))
    text->replace(at, from.size(), to);
}

bool write_page(const std::filesystem::path& path, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  std::ofstream file{path};
  file << text;
  file.close();
  if (!file) std::fprintf(stderr, "%s: error: cannot write this file\n", path.c_str());
  return static_cast<bool>(file);
}

}  // namespace

std::string manual_page(const CLI::App& program, const std::string& command, int section) {
  const CLI::App& app = command.empty() ? program : *program.get_subcommand(command);
  const std::string name = command.empty() ? program.get_name() : program.get_name() + "-" + command;
  const std::string spoken = command.empty() ? name : program.get_name() + " " + command;
  std::string roff = ".TH " + escaped(upper(name)) + " " + std::to_string(section) + " \"\" \"" +
                     escaped("Takt " TAKT_VERSION) + "\" \"Takt\"\n";
  roff += ".SH NAME\n" + escaped(name) + " \\- " + line(app.get_description());
  roff += ".SH SYNOPSIS\n" + synopsis(spoken, app);
  if (const OptionList positionals = positionals_of(app); !positionals.empty())
    roff += ".SH ARGUMENTS\n" + option_items(positionals);
  roff += ".SH OPTIONS\n" + option_items(options_of(app));
  if (const auto commands = commands_of(app); !commands.empty()) {
    roff += ".SH COMMANDS\n";
    for (const auto* inner : commands) {
      if (command.empty()) {
        roff += ".TP\n" + bold(inner->get_name()) + "\n" + line(inner->get_description());
        continue;
      }
      const std::string called = spoken + " " + inner->get_name();
      roff += ".SS " + escaped(called) + "\n" + line(inner->get_description()) + ".PP\n" +
              synopsis(called, *inner) + option_items(positionals_of(*inner)) +
              option_items(options_of(*inner)) + footer_of(*inner);
    }
  }
  if (const std::string footer = footer_of(app); !footer.empty()) roff += ".SH NOTES\n" + footer;
  std::string others;
  const auto mention = [&others](const std::string& page, int number) {
    others += (others.empty() ? "" : ",\n") + (".BR " + escaped(page)) + " (" + std::to_string(number) + ")";
  };
  if (command.empty()) {
    for (const auto* c : commands_of(program)) mention(name + "-" + c->get_name(), section);
    if (name == "takt")
      mention("takt-node", 8);
    else
      mention("takt", 1);
  } else {
    mention(program.get_name(), section);
    mention("takt-node", 8);
  }
  return roff + ".SH SEE ALSO\n" + others + "\n";
}

std::string bash_completion(const CLI::App& program) {
  std::string values;
  std::string words;
  add_cases(program, "", &values, &words);
  std::string function = program.get_name();
  replace(&function, "-", "_");
  std::string script{kBash};
  replace(&script, "@VALUES@", values);
  replace(&script, "@WORDS@", words);
  replace(&script, "@FUNCTION@", function);
  replace(&script, "@NAME@", program.get_name());
  return script;
}

void tidy_help(CLI::App& program) {
  program.get_formatter()->label("Excludes", "not with");
  program.get_formatter()->label("Needs", "needs");
  for (CLI::Option* option : program.get_options()) {
    if (option->get_positional() && option->get_type_name() == "TEXT") option->type_name("");
  }
  for (CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) tidy_help(*command);
}

namespace {

/// One line for each unknown word that resembles an option of the command or stands for one.
std::string suggested_options(const CLI::App& program, const CLI::App& command) {
  std::vector<std::string> names;
  for (const auto* option : options_of(command)) {
    for (const std::string& name : names_of(option)) names.push_back(name);
  }
  std::string lines;
  const CLI::Option* device = program.get_option_no_throw("--device");  // an option of takt-node
  for (const std::string& word : program.remaining(true)) {
    if (!word.starts_with("-") && device != nullptr && device->empty())
      lines += "write --device " + on_one_line(word) + "\n";
    if (!word.starts_with("--")) continue;
    const std::string unknown = word.substr(0, word.find('='));
    if (unknown == "--interface")
      lines += "there is no option --interface; set the environment variable TAKT_INTERFACE to the address\n";
    const std::string_view meant = nearest(unknown, {names.begin(), names.end()});
    if (!meant.empty())
      lines += "there is no option " + on_one_line(unknown) + "; did you mean " + std::string{meant} + "?\n";
  }
  return lines;
}

/// What CLI11 says, or a clearer sentence if an option that takes a number has another value.
std::string what_is_wrong(const CLI::Error& error) {
  const std::string text = error.what();
  constexpr std::string_view kValue = ": Value ";
  constexpr std::string_view kRange = " not in range ";
  const std::size_t value = text.find(kValue);
  const std::size_t range = text.rfind(kRange);
  if (value != std::string::npos && range != std::string::npos && value + kValue.size() <= range) {
    const std::string given = text.substr(value + kValue.size(), range - value - kValue.size());
    std::string bounds = text.substr(range + kRange.size());
    // CLI11 2.4 writes [0 - 232], and earlier versions 0 to 232.
    if (const std::size_t dash = bounds.find(" - "); bounds.starts_with('[') && dash != std::string::npos)
      bounds = bounds.substr(1, dash - 1) + " to " + bounds.substr(dash + 3, bounds.size() - dash - 4);
    return text.substr(0, value) + " takes a number, " + bounds + ", not " + in_quotes(given);
  }
  constexpr std::string_view kBegin = "Could not convert: ";
  const std::size_t equals = text.find(" = ");
  if (!text.starts_with(kBegin) || equals == std::string::npos) return text;
  return text.substr(kBegin.size(), equals - kBegin.size()) + " takes a number, not " +
         in_quotes(text.substr(equals + 3));
}

/// The message for wrong usage: only the error and the usage line. The whole help text would scroll the error
/// off the screen.
std::string wrong_usage(const CLI::App* program, const CLI::Error& error) {
  const std::string help = program->help();
  std::string wrong = std::string{"error: "} + on_one_line(what_is_wrong(error)) + "\n";
  const CLI::App* meant = program;
  std::string name = program->get_name();
  while (!meant->get_subcommands().empty()) {
    meant = meant->get_subcommands().front();
    name += " " + meant->get_name();
  }
  if (meant == program && !program->get_subcommands({}).empty()) return wrong + "\n" + help;
  const std::size_t usage = help.find("Usage: ");
  wrong += suggested_options(*program, *meant);
  return wrong + help.substr(usage, help.find('\n', usage) - usage) + "\n" + name +
         " --help explains all options\n";
}

}  // namespace

void shorten_errors(CLI::App& program) { program.failure_message(wrong_usage); }

int explain(const CLI::App& program, const CLI::ParseError& error) {
  std::ostringstream out;
  const int status = program.exit(error, out, std::cerr) == 0 ? 0 : 2;
  return print_unchanged(out.str()) ? status : 1;
}

int write_pages(const CLI::App& program, const std::string& folder, int section) {
  namespace fs = std::filesystem;
  const std::string number = std::to_string(section);
  const fs::path manual = fs::path{folder} / "man" / ("man" + number);
  const std::string name = program.get_name();
  bool ok = write_page(manual / (name + "." + number), manual_page(program, "", section));
  for (const auto* command : commands_of(program))
    ok = write_page(manual / (name + "-" + command->get_name() + "." + number),
                    manual_page(program, command->get_name(), section)) &&
         ok;
  ok = write_page(fs::path{folder} / "completions" / name, bash_completion(program)) && ok;
  return ok ? 0 : 1;
}

}  // namespace takt::tool
