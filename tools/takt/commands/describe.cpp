#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>

#include <CLI/CLI.hpp>

#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/host/component_path.hpp>
#include <takt/security/hash.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "reports/describe_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct DescribeOptions {
  std::vector<std::string> words;  ///< the arguments: files, module names, and "name=value" for a program
  bool json = false;
  bool xml = false;
  bool iso = false;
  std::string operation;  ///< the operation type in the profile
};

bool is_property(const std::string& word) {
  return word.find('=') != std::string::npos && !std::filesystem::exists(word);
}

int print_component_list(const std::vector<std::string>& folders, const DescribeOptions& options) {
  const auto files = host::list_components(folders);
  if (files.empty()) {
    std::string looked;
    for (const std::string& folder : folders) looked += (looked.empty() ? "" : ", ") + folder;
    return refuse({fail("no components found (looked in " + looked + ")",
                        "build components, or add their folder to TAKT_COMPONENT_PATH")});
  }
  return print(options.json ? component_list_json(files) : component_list_text(files, terminal_style())) ? 0
                                                                                                         : 1;
}

Result<Described> describe_module(const model::Cell& cell, const model::Device& device,
                                  const model::Module& module) {
  const auto at_line = [&](Problems problems) {
    for (Problem& problem : problems)
      problem = model::problem_at(cell.texts(), model::line_of_file(module), std::move(problem.what),
                                  std::move(problem.fix));
    return problems;
  };
  auto path = host::find_component(module.filename, cell.file);
  if (!path) return at_line(path.problems());
  const bool process = module.type == model::ModuleType::process;
  warn(at_line(host::misspelt_hooks(*path)));
  auto component = host::describe(*path, process ? host::arguments_of(module) : host::Arguments{});
  if (!component) return at_line(component.problems());
  return Described{*path, security::short_hash(*path), std::move(*component), cell.name, device.name, module};
}

/// Describes the modules of a descriptor with the given names, each DEVICE.MODULE or MODULE. If `names` is
/// empty, describes all modules. Adds to `problems` why a module cannot be described.
std::vector<Described> describe_cell(const std::string& file, const std::vector<std::string>& names,
                                     Problems& problems) {
  auto cell = descriptor::load(file);
  if (!cell) {
    problems = cell.problems();
    return {};
  }
  std::vector<Described> all;
  std::vector<std::string> known;
  std::vector<bool> found(names.size());
  for (const model::Device& device : cell->devices) {
    for (const model::Module& module : device.modules) {
      known.push_back(device.name + "." + module.name);
      bool wanted = names.empty();
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] != known.back() && names[i] != module.name) continue;
        wanted = found[i] = true;
      }
      if (!wanted) continue;
      auto described = describe_module(*cell, device, module);
      if (described)
        all.push_back(std::move(*described));
      else
        std::copy(described.problems().begin(), described.problems().end(), std::back_inserter(problems));
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (found[i]) continue;
    std::vector<std::string_view> choices;
    for (const std::string_view path : known)
      choices.push_back(names[i].find('.') == std::string::npos ? path.substr(path.find('.') + 1) : path);
    problems.push_back({file, "there is no module " + in_quotes(names[i]), suggestion(names[i], choices)});
  }
  return all;
}

/// Describes components. Adds to `problems` why a component cannot be described.
std::vector<Described> describe_files(const std::vector<std::string>& files,
                                      const host::Arguments& properties, Problems& problems) {
  std::vector<Described> all;
  for (const std::string& file : files) {
    auto path = host::find_component(file, "");
    if (!path && !file.ends_with(".so") && !file.ends_with(".exe")) {
      Problem problem = path.problems()[0];
      problem.fix += std::string{problem.fix.ends_with("?") ? " To" : "; to"} +
                     " describe a module of a cell, write takt describe CELL.xml " + file;
      path = problem;
    }
    auto component = path ? host::describe(*path, properties) : Result<host::Description>{path.problems()};
    if (component) {
      Problems warnings = host::misspelt_hooks(*path);
      for (Problem& warning : warnings) warning.where = *path;
      warn(warnings);
      all.push_back({*path, security::short_hash(*path), std::move(*component)});
    } else {
      std::copy(component.problems().begin(), component.problems().end(), std::back_inserter(problems));
    }
  }
  return all;
}

std::optional<model::Operation> operation_named(const std::string& name) {
  for (const auto operation :
       {model::Operation::periodic, model::Operation::sporadic, model::Operation::non_real}) {
    if (name == to_text(operation)) return operation;
  }
  return std::nullopt;
}

int describe(const DescribeOptions& options) {
  std::vector<std::string> files;
  host::Arguments properties;
  for (const std::string& word : options.words) (is_property(word) ? properties : files).push_back(word);
  if (files.empty()) return print_component_list(host::component_folders(), options);
  std::error_code error;
  if (files.size() == 1 && std::filesystem::is_directory(files[0], error))
    return print_component_list({files[0]}, options);

  const bool of_cell = files[0].ends_with(".xml");
  if ((of_cell || files.size() > 1) && !properties.empty())
    return refuse({fail(
        of_cell ? "property " + in_quotes(properties[0]) + " is not allowed together with a descriptor"
                : "property " + in_quotes(properties[0]) + " is not allowed together with several components",
        of_cell ? "leave out the property; the descriptor sets the properties of its modules"
                : "give only one program")});
  Problems problems;
  const auto all = of_cell ? describe_cell(files[0], {files.begin() + 1, files.end()}, problems)
                           : describe_files(files, properties, problems);
  if (all.empty() && !problems.empty()) return refuse(problems);
  if (options.iso && all.size() + problems.size() != 1)
    return refuse(
        {fail("--iso22166 describes one module, but the number of modules here is " +
                  std::to_string(all.size() + problems.size()),
              of_cell ? "add DEVICE.MODULE after the descriptor to choose one" : "give only one file")});
  std::string text;
  for (const Described& described : all) {
    if (options.json)
      text += describe_json(described);
    else if (options.xml)
      text += describe_xml(described);
    else if (options.iso)
      text += iso22166_profile(described, options.operation.empty() ? operation_of(described)
                                                                    : operation_named(options.operation));
    else
      text += (text.empty() ? "" : "\n") + describe_text(described, terminal_style());
  }
  const bool printed = print(text);
  complain(problems);
  return printed && problems.empty() ? 0 : 1;
}

}  // namespace

void add_describe(CLI::App& app, Chosen& chosen) {
  const auto options = std::make_shared<DescribeOptions>();
  auto* command = app.add_subcommand(
      "describe",
      "Print the ports, services, properties and hooks of a component; without FILE, list all components");
  command->add_option(
      "FILE", options->words,
      "components (.so or .exe), a folder with components, or a descriptor, with DEVICE.MODULE to select "
      "some of its modules. NAME=VALUE sets a property of a program, because its ports may depend on it");
  auto* json = command->add_flag("--json", options->json, "print one line of JSON for each component");
  auto* xml =
      command->add_flag("--xml", options->xml, "print a <module> element for a descriptor")->excludes(json);
  auto* iso =
      command->add_flag("--iso22166", options->iso, "print a module profile with the terms of ISO 22166-202")
          ->excludes(json)
          ->excludes(xml);
  command->add_option("--operation", options->operation, "the operation type to write into the profile")
      ->type_name("periodic|sporadic|non-real")
      ->check(CLI::IsMember({"periodic", "sporadic", "non-real"}).description(""))
      ->needs(iso);
  command->callback([options, &chosen] { chosen = [options] { return describe(*options); }; });
}

}  // namespace takt::tool
