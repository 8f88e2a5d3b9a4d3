#include <takt/host/component_path.hpp>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/os/writers.hpp>

namespace takt::host {

namespace fs = std::filesystem;

namespace {

ComponentCheck& requirement() {
  static ComponentCheck check;
  return check;
}

/// Returns the absolute path of a file if it passes open_component().
Result<std::string> checked(const fs::path& path) {
  std::error_code error;
  const std::string found = fs::absolute(path, error).string();
  if (auto opened = open_component(found); !opened) return opened.problems();
  return found;
}

/// Returns LD_LIBRARY_PATH for a program that runs from a copy of its file. For the loader, the copy has no
/// folder. So this function replaces $ORIGIN, which stands for the folder of the file, in the program's list
/// of folders. Returns nothing if the program's list does not contain $ORIGIN.
std::optional<std::string> library_path(const std::string& program, const os::Fd& copy) {
  std::string folders = os::library_folders(os::path_of(copy));
  const std::string as_written = folders;
  const std::string folder = fs::path{program}.parent_path().string();
  for (const std::string name : {"$ORIGIN", "${ORIGIN}"}) {
    for (std::size_t at = 0; (at = folders.find(name, at)) != std::string::npos; at += folder.size())
      folders.replace(at, name.size(), folder);
  }
  if (folders == as_written) return std::nullopt;
  const std::string before = os::environment("LD_LIBRARY_PATH");
  return before.empty() ? folders : before + ":" + folders;
}

/// Names the places that were searched, for an error message: the folders, or the paths if `name` has a
/// folder.
std::string places_of(const fs::path& name, const std::vector<std::string>& folders) {
  std::vector<std::string> places;
  for (const fs::path folder : folders) {
    std::error_code error;
    std::string place = name.has_parent_path() ? (folder / name).lexically_normal().string()
                                               : folder.lexically_normal().string();
    if (!fs::is_directory(folder, error)) {
      const std::string& written = folder.string();
      place += " (" + written + " does not exist";
      if (written.find_first_of(",;") != std::string::npos) place += "; separate folders with ':'";
      if (written.starts_with('~')) place += "; write $HOME instead of ~";
      place += ")";
    }
    if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(std::move(place));
  }
  std::string text = name.has_parent_path() ? "tried " : "looked in ";
  for (const std::string& place : places) text += (&place == &places[0] ? "" : ", ") + place;
  return text;
}

/// Returns, for an error message, what to do about a file that is in none of these folders.
std::string cure(const fs::path& name, const std::vector<std::string>& folders) {
  std::error_code error;
  std::vector<std::string> names;  // files of the same kind, in case the name is misspelled
  for (const fs::path folder : component_folders()) {
    const fs::path same = folder / name.filename();
    if (name.has_parent_path() && fs::is_regular_file(same, error)) {
      return "correct the path, or write " + name.filename().string() + " to use " +
             same.lexically_normal().string();
    }
  }
  for (const fs::path folder : folders) {
    for (const auto& entry : fs::directory_iterator{(folder / name).parent_path(), error}) {
      const fs::path other = entry.path().filename();
      if (!name.has_extension() && other.stem() == name &&
          (other.extension() == ".so" || other.extension() == ".exe"))
        return "did you mean " + other.string() + "?";
      if (other.extension() == name.extension()) names.push_back(other.string());
    }
  }
  // The extension is the same in all names, so only the stems are compared.
  std::vector<std::string> stems;
  for (const std::string& other : names) stems.push_back(fs::path{other}.stem().string());
  const std::string meant{nearest(name.stem().string(), {stems.begin(), stems.end()})};
  if (!meant.empty())
    return "did you mean " + (name.parent_path() / (meant + name.extension().string())).string() + "?";
  if (name.has_parent_path()) return "build it, or correct the path";
  return "build it, correct the name, or add its folder to TAKT_COMPONENT_PATH";
}

}  // namespace

void require_of_components(ComponentCheck check) { requirement() = std::move(check); }

Result<os::Fd> open_component(const std::string& path) {
  if (auto writers = os::check_writers(path); !writers) return writers.problems();
  if (!requirement()) return os::Fd{};
  auto copy = os::sealed_copy(path);
  if (!copy) return copy;
  auto required = requirement()(path, *copy);
  if (required) return copy;
  Problems problems = required.problems();
  for (Problem& problem : problems) {  // callers set `where` to the line of the descriptor
    if (!problem.where.empty()) problem.what = problem.where + ": " + problem.what;
    problem.where.clear();
  }
  return problems;
}

Result<os::Child> start_component(os::SpawnOptions options) {
  const auto copy = open_component(options.program);
  if (!copy) return copy.problems();
  if (*copy) {
    options.copy = &*copy;
    if (auto path = library_path(options.program, *copy))
      options.environment.emplace_back("LD_LIBRARY_PATH", std::move(*path));
  }
  return os::Child::spawn(options);
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
  std::vector<std::string> folders{
      fs::absolute(descriptor.empty() ? "./" : descriptor, error).parent_path().string()};
  if (!fs::path{filename}.is_absolute()) {
    for (std::string& folder : component_folders()) folders.push_back(std::move(folder));
  }
  for (const std::string& folder : folders) {
    const fs::path path = (fs::path{folder} / filename).lexically_normal();
    if (fs::is_regular_file(path, error)) return checked(path);
    if (fs::exists(path, error)) return fail(path.string() + " is not a file", "name a component's file");
  }
  return fail("there is no file " + filename + " (" + places_of(filename, folders) + ")",
              cure(filename, folders));
}

Result<std::string> find_on_component_path(const std::string& filename) {
  std::error_code error;
  const std::vector<std::string> folders = component_folders();
  for (const std::string& each : folders) {
    const fs::path folder = fs::absolute(each, error).lexically_normal() / "";
    const fs::path path = (folder / filename).lexically_normal();
    if (path.string().starts_with(folder.string()) && fs::is_regular_file(path, error)) return path.string();
  }
  const std::string name = fs::path{filename}.filename().string();
  const std::string where =
      filename.find('/') == std::string::npos
          ? ""
          : "; name it " + name + ", without a path, because a node loads no other files";
  return fail(
      "there is no file " + filename + " on this device's component path (" + places_of(name, folders) + ")",
      "copy it to one of these folders, or add its folder to TAKT_COMPONENT_PATH of takt-node" + where);
}

}  // namespace takt::host
