// takt new: creates the files of a new component, which builds, passes its tests and runs without changes; or
// the files of a new cell with two devices.
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <takt/core/words.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "scaffold/scaffold.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

namespace fs = std::filesystem;

struct NewOptions {
  std::string name;
  std::string folder;  ///< the folder to create; if empty, it has the name of the component
  std::string type = "thread";
  std::string operation = "periodic";
  std::string language = "c++";
};

/// Writes the files. If one of them already exists, fails and writes none of them.
Result<void> write_new_files(const fs::path& folder, const std::vector<NewFile>& files) {
  std::error_code error;
  for (const NewFile& file : files) {
    if (fs::exists(folder / file.name, error))
      return fail((folder / file.name).string() + " already exists",
                  "choose another folder, or remove the file");
  }
  fs::create_directories(folder, error);
  if (error)
    return fail("cannot create the folder " + folder.string() + ": " + error.message(),
                "choose another folder");
  for (const NewFile& file : files) {
    std::ofstream stream{folder / file.name, std::ios::binary};
    stream << file.text;
    if (!stream.flush())
      return fail((folder / file.name).string() + " cannot be written",
                  "check the free space on the disk and the permissions of the folder");
  }
  return {};
}

int make(const NewOptions& options) {
  const bool cell = options.name == "cell";
  const std::string name =
      cell ? (options.folder.empty() ? "cell" : fs::path{options.folder}.filename().string()) : options.name;
  const auto files =
      cell ? new_cell(name)
           : new_component(
                 {.name = options.name,
                  .type = options.type == "thread" ? model::ModuleType::thread : model::ModuleType::process,
                  .operation = options.operation == "periodic" ? model::Operation::periodic
                                                               : model::Operation::sporadic,
                  .in_c = options.language == "c"});
  if (!files) {
    complain(files.problems());
    return 1;
  }
  const fs::path folder = options.folder.empty() ? fs::path{name} : fs::path{options.folder};
  if (auto written = write_new_files(folder, *files); !written) {
    complain(written.problems());
    return 1;
  }
  const std::string shown = on_one_line(folder.string());
  std::string text = fmt::format("{}:", shown);
  for (const NewFile& file : *files) text += " " + file.name;
  text +=
      cell ? fmt::format("\nnext:\n  takt run {}/{}.xml --for 5\n", shown, name)
           : fmt::format(
                 "\nnext:\n  cd {0}\n  cmake -S . -B build && cmake --build build && ctest --test-dir build\n"
                 "  TAKT_COMPONENT_PATH=$PWD/build/components takt run {1}.xml --for 5\n",
                 shown, name);
  return print(text) ? 0 : 1;
}

}  // namespace

void add_new(CLI::App& app, Chosen& chosen) {
  auto* command = app.add_subcommand(
      "new",
      "Create a component that builds, passes its tests and runs as it is; or, with the name 'cell', a cell");
  auto options = std::make_shared<NewOptions>();
  command->add_option("NAME", options->name, "the name of the component, such as belt_drive; or 'cell'")
      ->required();
  command->add_option("DIR", options->folder, "the folder to write (default: the name of the component)");
  command
      ->add_option("--type", options->type,
                   "thread (a .so that the scheduler calls) or process (a program that it releases)")
      ->type_name("thread|process")
      ->check(CLI::IsMember({"thread", "process"}).description(""))
      ->capture_default_str();
  command
      ->add_option("--operation", options->operation,
                   "periodic (runs once in each period) or sporadic (runs when a sample arrives)")
      ->type_name("periodic|sporadic")
      ->check(CLI::IsMember({"periodic", "sporadic"}).description(""))
      ->capture_default_str();
  command->add_option("--language", options->language, "the programming language")
      ->type_name("c++|c")
      ->check(CLI::IsMember({"c++", "c"}).description(""))
      ->capture_default_str();
  command->callback([options, &chosen] { chosen = [options] { return make(*options); }; });
}

}  // namespace takt::tool
