#include "scaffold/scaffold.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include <takt/model/validate.hpp>

namespace takt::tool {

namespace {

struct Template {
  std::string_view folder;
  std::string_view name;
  std::string_view text;
};

// The files of the folder templates/, which the build embeds.
constexpr Template kTemplates[] = {
#include "templates.inc"
};

using Values = std::map<std::string, std::string, std::less<>>;

/// Replaces each @word@ in a template by the value of the word, if `values` has one.
std::string filled(std::string_view text, const Values& values) {
  std::string result;
  while (!text.empty()) {
    const std::size_t begin = text.find('@');
    const std::size_t end = begin == text.npos ? text.npos : text.find('@', begin + 1);
    if (end == text.npos) break;
    const auto found = values.find(text.substr(begin + 1, end - begin - 1));
    if (found == values.end()) {  // this @ is ordinary text
      result += text.substr(0, end);
      text.remove_prefix(end);
      continue;
    }
    result += text.substr(0, begin);
    result += found->second;
    text.remove_prefix(end + 1);
  }
  return result += text;
}

/// The C++ class name for a component: "BeltDrive" for "belt_drive".
std::string class_name(std::string_view name) {
  std::string result;
  bool up = true;
  for (const char c : name) {
    if (c == '_') {
      up = true;
      continue;
    }
    result += up ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    up = false;
  }
  return result;
}

/// Checks that the name is valid for a component, a C++ namespace, an IDL module and a CMake target.
Result<void> check_name(const std::string& name) {
  constexpr const char* kRule =
      "start with a lower-case letter, then use lower-case letters, digits and single underscores, at most "
      "48 characters, such as belt_drive";
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  const bool letter = !name.empty() && name[0] >= 'a' && name[0] <= 'z';
  if (!letter || name.size() > 48 || !std::all_of(name.begin(), name.end(), fits) || name.back() == '_' ||
      name.find("__") != name.npos) {
    return fail("'" + name + "' is not a valid component name", kRule);
  }
  // These names would collide with targets of CMake or Takt, or with the build folder.
  constexpr std::array<std::string_view, 9> kTaken{"all",  "build", "clean",   "help",      "install",
                                                   "test", "takt",  "package", "edit_cache"};
  if (std::find(kTaken.begin(), kTaken.end(), name) != kTaken.end())
    return fail("'" + name + "' is reserved for a build target",
                "choose another name, such as " + name + "_module");
  return {};
}

std::vector<NewFile> files_of(std::string_view folder, const Values& values,
                              const std::map<std::string, std::string, std::less<>>& renamed) {
  std::vector<NewFile> files;
  for (const Template& one : kTemplates) {
    if (one.folder != folder) continue;
    const bool source = one.name.starts_with("thread_") || one.name.starts_with("process_");
    const auto name = renamed.find(one.name);
    if (source && name == renamed.end()) continue;
    files.push_back(
        {filled(source ? std::string_view{name->second} : one.name, values), filled(one.text, values)});
  }
  std::sort(files.begin(), files.end(), [](const NewFile& a, const NewFile& b) { return a.name < b.name; });
  return files;
}

}  // namespace

Result<std::vector<NewFile>> new_component(const NewComponent& wanted) {
  if (auto checked = check_name(wanted.name); !checked) return checked.problems();
  const bool thread = wanted.type == model::ModuleType::thread;
  const bool sporadic = wanted.operation == model::Operation::sporadic;
  const std::string suffix = wanted.in_c ? ".c" : ".cpp";
  const Values values{{"name", wanted.name},
                      {"Name", class_name(wanted.name)},
                      {"add", thread ? "takt_add_component" : "takt_add_process"},
                      {"source", wanted.name + suffix},
                      {"file", wanted.name + (thread ? ".so" : ".exe")},
                      {"moduletype", to_text(wanted.type)},
                      {"operationtype", to_text(wanted.operation)},
                      {"timing", sporadic ? "deadline" : "period"},
                      {"sporadic", sporadic ? "true" : "false"},
                      {"queue", sporadic ? R"( kind="queue" depth="8")" : ""},
                      {"inport", sporadic ? "event" : "in"},
                      {"language", wanted.in_c ? "C" : "C++"}};
  const std::string source = std::string{to_text(wanted.type)} + "_" + to_text(wanted.operation) + suffix;
  return files_of("component", values, {{source, "@source@"}});
}

Result<std::vector<NewFile>> new_cell(const std::string& name) {
  if (!model::is_valid_name(name)) {
    return fail("'" + name + "' is not a valid cell name",
                "start with a letter or '_', then use letters, digits, '_' and '-', at most 63 characters");
  }
  return files_of("cell", {{"name", name}}, {});
}

}  // namespace takt::tool
