#include <takt/host/component_path.hpp>

#include <filesystem>
#include <utility>

#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/process.hpp>

namespace takt::host {

namespace fs = std::filesystem;

namespace {

std::function<Result<void>(const std::string&)>& requirement() {
  static std::function<Result<void>(const std::string&)> check;
  return check;
}

/// Fails if everybody may write to the file or its folder: anyone who can replace a component can run any
/// code.
Result<void> check_writers(const fs::path& path) {
  for (const fs::path& each : {path, path.parent_path()}) {
    const auto rights = os::rights_of(each.string());
    if (rights && rights->others_write)
      return fail("everybody may write to " + each.string(), "run chmod o-w " + each.string());
  }
  return {};
}

}  // namespace

void require_of_components(std::function<Result<void>(const std::string& path)> check) {
  requirement() = std::move(check);
}

std::vector<std::string> component_folders() {
  std::vector<std::string> folders;
  std::string path = os::environment("TAKT_COMPONENT_PATH");
  while (!path.empty()) {
    const std::size_t colon = path.find(':');
    if (colon != 0) folders.push_back(path.substr(0, colon));
    path = colon == std::string::npos ? "" : path.substr(colon + 1);
  }
  // In an installation, the folder `components` is in the folder of takt-host. In a build, it is next to the
  // folder of the programs.
  const fs::path ours = os::private_directory();
  const bool built = ours == os::program_directory();
  folders.push_back(((built ? ours.parent_path() : ours) / "components").string());
  return folders;
}

Result<std::string> find_component(const std::string& filename, const std::string& descriptor) {
  std::error_code error;
  const fs::path name{filename};
  std::vector<fs::path> candidates;
  if (name.is_absolute()) {
    candidates.push_back(name);
  } else {
    candidates.push_back(fs::absolute(descriptor.empty() ? "./" : descriptor, error).parent_path() / name);
    for (const std::string& folder : component_folders()) {
      candidates.push_back(fs::path{folder} / name);
      if (name.has_parent_path()) candidates.push_back(fs::path{folder} / name.filename());
    }
  }
  std::string tried;
  for (const fs::path& candidate : candidates) {
    const fs::path path = candidate.lexically_normal();
    if (fs::is_regular_file(path, error)) {
      const fs::path found = fs::absolute(path, error);
      if (auto checked = check_writers(found); !checked) return checked.problems();
      if (requirement()) {
        if (auto checked = requirement()(found.string()); !checked) {
          Problems problems = checked.problems();
          for (Problem& problem : problems) {  // the caller adds the descriptor's line
            if (!problem.where.empty()) problem.what = problem.where + ": " + problem.what;
            problem.where.clear();
          }
          return problems;
        }
      }
      return found.string();
    }
    const std::string folder = path.parent_path().string();
    if (fs::exists(path, error)) return fail(path.string() + " is not a file", "name a component's file");
    if (("," + tried + ",").find(" " + folder + ",") == std::string::npos)
      tried += (tried.empty() ? " " : ", ") + folder;
  }
  // Suggest a file of the same kind from these folders, in case the name is misspelled.
  std::vector<std::string> names;
  for (const fs::path& candidate : candidates) {
    for (const auto& entry : fs::directory_iterator{candidate.parent_path(), error}) {
      if (entry.path().extension() == name.extension()) names.push_back(entry.path().filename().string());
    }
  }
  const std::string meant{nearest(name.filename().string(), {names.begin(), names.end()})};
  return fail("there is no file " + filename + " (looked in" + tried + ")",
              meant.empty() ? "build it, correct the name, or add its folder to TAKT_COMPONENT_PATH"
                            : "did you mean " + meant + "?");
}

}  // namespace takt::host
