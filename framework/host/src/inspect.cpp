#include <takt/host/inspect.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/hex.hpp>
#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/host/component_path.hpp>
#include <takt/host/thread_module.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/json.hpp>
#include <takt/model/validate.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

namespace takt::host {

namespace {

using json = nlohmann::ordered_json;
constexpr auto kLimit = std::chrono::seconds{5};

json problems_json(const Problems& problems) {
  json list = json::array();
  for (const Problem& problem : problems) list.push_back({{"what", problem.what}, {"fix", problem.fix}});
  return list;
}

Problems problems_from(const json& list) {
  Problems problems;
  for (const json& entry : list) problems.push_back(fail(entry.at("what"), entry.at("fix")));
  return problems;
}

/// Returns the module's ports as the JSON text that model::parse_ports() reads.
std::string ports_of(const ThreadModule& module) {
  json list = json::array();
  for (const PortBase* port : module.ports()) {
    list.push_back({{"name", port->name()},
                    {"direction", to_text(port->direction())},
                    {"role", to_text(port->role())},
                    {"description", port->type().description},
                    {"text", port->text()},
                    {"object", port->value_size() != 0},
                    {"safe", in_hex(port->safe())}});
  }
  return model::json_text({{"ports", list}});
}

/// Returns the problems that a program printed on standard error before it ended. Each problem is one line of
/// the form "what; fix".
Problems printed_problems(const std::string& text) {
  Problems problems;
  std::istringstream lines{text};
  for (std::string line; std::getline(lines, line);) {
    const auto end = line.find("; ");
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    problems.push_back(fail(line.substr(0, end), end == std::string::npos ? "" : line.substr(end + 2)));
  }
  return problems;
}

/// The data that a program reports about itself.
struct ProgramAnswer {
  std::string operation;
  std::vector<model::Port> ports;
  std::vector<PropertyDescription> properties;
  Problems problems;  ///< problems of the program's properties and of their values
  std::optional<SavedDescription> saved{};
};

std::optional<SavedDescription> saved_of(const json& answer) {
  const auto at = answer.find("saved");
  if (at == answer.end()) return std::nullopt;
  return SavedDescription{.version = at->at("version"), .bytes = at->at("bytes")};
}

/// Reports the ports and properties of a program that have invalid names.
Problems wrong_names(const ProgramAnswer& answer) {
  Problems problems;
  const auto check = [&](const std::string& what, const std::string& name) {
    if (!model::is_valid_name(name))
      problems.push_back(
          fail("the program has a " + what + " with the invalid name " + in_quotes(name), model::kNameRule));
  };
  for (const model::Port& port : answer.ports) {
    // The ports of a service or client NAME are called NAME/request and NAME/reply.
    const bool plain = port.role == model::Role::plain;
    check("port", plain ? port.name : port.name.substr(0, port.name.rfind('/')));
  }
  for (const PropertyDescription& property : answer.properties) check("property", property.name);
  return problems;
}

Result<ProgramAnswer> parse_answer(const std::string& text) {
  auto ports = model::parse_ports(text);
  if (!ports) return ports.problems();
  const json answer = model::parse_json(text);  // an object, because parse_ports() succeeded
  auto properties = parse_properties(model::json_text(answer.value("properties", json::array())));
  if (!properties) return properties.problems();
  ProgramAnswer found{answer.value("operation", ""), std::move(*ports), std::move(*properties),
                      problems_from(answer.value("problems", json::array())), saved_of(answer)};
  for (Problem& problem : wrong_names(found)) found.problems.push_back(std::move(problem));
  return found;
}

constexpr const char* kProcessLibrary = "libtakt_process.so";

/// Returns the names of a file's dynamic symbols and libraries; empty if the file is not an ELF file.
std::string dynamic_names(const std::string& path) { return os::read_section(path, ".dynstr").value_or(""); }

/// True if the program must be started to ask for its description. A script is started, because it may start
/// any program. A program that is not linked with libtakt_process cannot answer, so it is not started.
bool may_answer(const std::string& path) {
  const std::string names = dynamic_names(path);
  return names.empty() || names.find(kProcessLibrary) != std::string::npos;
}

/// True if the program calls initPeriodExe() or initSporadicExe().
bool calls_init(const std::string& path) {
  const std::string names = dynamic_names(path);
  const auto has = [&names](std::string_view symbol) {
    return names.find('\0' + std::string{symbol} + '\0') != std::string::npos;
  };
  return has("initPeriodExe") || has("initSporadicExe");
}

const char* init_function(model::Operation operation) {
  return operation == model::Operation::periodic ? "initPeriodExe()" : "initSporadicExe()";
}

/// Starts a program with these arguments. The program describes itself and ends. If the program ended with an
/// error message about its arguments, sets `*rejected`, and the result is that message.
Result<ProgramAnswer> ask_program(const std::string& path, const Arguments& arguments,
                                  bool* rejected = nullptr) {
  auto sockets = os::MessageSocket::pair();
  if (!sockets) return sockets.problems();
  os::MessageSocket& ours = sockets->first;
  auto child =
      start_component({.program = path,
                       .arguments = arguments,
                       .environment = {{"TAKT_DESCRIBE_FD", std::to_string(sockets->second.fd().get())}},
                       .inherit = {&sockets->second.fd()},
                       .capture_output = true,
                       .whole_tree = true,
                       .others_stay = true});  // a copy of the program may still answer
  if (!child) return child.problems();
  sockets->second.close();
  std::string printed;
  const auto read_output = [&] {
    bool end = false;
    printed += os::read_available(child->error, &end);
    os::read_available(child->output, &end);  // discards standard output, because a full pipe would block the
                                              // program
  };
  std::optional<os::ProcessEnd> ended;
  // If the process has ended but the socket is open, a copy of the process still runs, and may answer.
  for (const Instant limit = os::now() + kLimit; (!ended || !ours.closed()) && os::now() < limit;) {
    if (const auto text = ours.receive()) return parse_answer(*text);
    if (!ended) ended = child->poll();
    read_output();
    if (!ended || !ours.closed()) os::wait_readable({&ours.fd()}, ours.closed() ? 1 : 20);
  }
  if (const auto text = ours.receive()) return parse_answer(*text);
  if (ended && !ended->signalled && ended->code != 0) {
    Problems problems = printed_problems(printed);
    if (rejected != nullptr) *rejected = !problems.empty();
    if (!problems.empty()) return problems;
  }
  return fail(path + " did not call initPeriodExe() or initSporadicExe() " +
                  (ended ? "before it " + ended->text() : "within " + to_text(kLimit) + " of its start"),
              ended && ended->signalled ? "find the cause of the crash in a debugger: gdb " + path
                                        : "call one of them at the beginning of main()");
}

Result<void> load(ThreadModule& module, const std::string& path, os::Library::Globals globals,
                  bool sporadic) {
  auto copy = open_component(path);
  if (!copy) return copy.problems();
  const auto origin = *copy ? os::Library::Origin::ignored : os::Library::Origin::searched;
  return module.load(path, globals, sporadic, std::move(*copy), origin);
}

json describe_loaded(const ThreadModule& module, const std::string& path) {
  json answer{
      {"name", std::filesystem::path{path}.stem().string()}, {"interface", "c"}, {"hooks", module.hooks()}};
  answer["properties"] = json::array();
  answer["ports"] = ports_of(module);
  if (module.component() != nullptr) {
    answer["name"] = module.component_name();
    answer["interface"] = "c++";
  }
  if (module.saves())
    answer["saved"] = {{"version", module.saves()->version}, {"bytes", module.saves()->size}};
  for (const PropertyBase* property : module.properties()) {
    answer["properties"].push_back({{"name", property->name()},
                                    {"type", to_text(property->type())},
                                    {"default", property->default_text()},
                                    {"range", property->range_text()},
                                    {"min", property->min_text()},
                                    {"max", property->max_text()},
                                    {"unit", property->unit()},
                                    {"text", property->text()}});
  }
  return answer;
}

// A module that uses a component file. One child process checks a file for all modules that use it.
struct Use {
  std::size_t device;
  std::size_t module;
};

json check_uses(const std::string& path, const model::Cell& cell, const std::vector<Use>& uses) {
  json answer = json::array();
  std::set<std::size_t> loaded;  // devices for which this loop has seen a C module of this file
  for (const Use& use : uses) {
    const model::Module& wanted = cell.devices[use.device].modules[use.module];
    ThreadModule module;
    const bool again = loaded.count(use.device) != 0;  // then the host also gives this module its own globals
    Result<void> result = load(module, path, again ? os::Library::Globals::own : os::Library::Globals::shared,
                               wanted.operation == model::Operation::sporadic);
    const bool is_loaded = result.ok();  // the ports of a file that was not loaded are unknown
    if (result && module.component() == nullptr) loaded.insert(use.device);
    if (result && module.declares_properties()) {
      result = module.set(values_of(wanted));
    }
    answer.push_back({{"problems", problems_json(result ? Problems{} : result.problems())},
                      {"ports", is_loaded ? json(ports_of(module)) : json{}}});
  }
  return answer;
}

// Adds the problems in `found` to `problems`. Each problem gets the line of the property that it names, or
// the line `other` if it names none.
void add_at(const model::Cell& cell, const model::Module& module, model::Line other, const Problems& found,
            Problems& problems) {
  for (const Problem& problem : found) {
    model::Line line = other;
    for (const model::PropertyValue& property : module.properties) {
      if (problem.what.find("'" + property.name + "'") != std::string::npos) line = property.line;
    }
    problems.push_back(
        model::problem_at(cell.texts(), line, "module " + module.name + ": " + problem.what, problem.fix));
  }
}

/// Like the function above, with the line of the component's file.
void add_at(const model::Cell& cell, const model::Module& module, const Problems& found, Problems& problems) {
  add_at(cell, module, model::line_of_file(module), found, problems);
}

/// Returns a problem if the init function that a program calls does not match the module's operation type.
/// `called` is the operation type of that function.
Problems check_operation(const model::Module& module, const std::string& called) {
  if (called == to_text(module.operation)) return {};
  const bool periodic = called == to_text(model::Operation::periodic);
  return {fail(
      std::string{"the program calls "} +
          init_function(periodic ? model::Operation::periodic : model::Operation::sporadic) + ", so it is " +
          called,
      "use <operationtype>" + called + "</operationtype> and <" + (periodic ? "period" : "deadline") + ">")};
}

bool is_connected(const model::Cell& cell, const std::string& device, const std::string& module) {
  return std::any_of(cell.connections.begin(), cell.connections.end(), [&](const model::Connection& c) {
    return (c.from.device == device && c.from.module == module) ||
           (c.to.device == device && c.to.module == module);
  });
}

}  // namespace

irp::Property::Values values_of(const model::Module& module) {
  irp::Property::Values values;
  for (const model::PropertyValue& property : module.properties) {
    if (property.name != kLogLevelProperty) values.emplace_back(property.name, property.value);
  }
  return values;
}

Arguments arguments_of(const model::Module& module) {
  Arguments arguments = module.arguments;
  for (const auto& [name, value] : values_of(module)) arguments.push_back(name + "=" + value);
  return arguments;
}

Result<Description> describe(const std::string& path, const Arguments& arguments) {
  if (!os::is_shared_object(path)) {
    if (!os::is_executable(path))
      return fail(path + " is neither a shared object nor a program", "name a component's file");
    Description program{.name = std::filesystem::path{path}.stem().string(),
                        .text = component_text(path),
                        .version = component_version(path),
                        .interface = "process",
                        .operation = {},
                        .hooks = {},
                        .properties = {},
                        .ports = {},
                        .saved = {}};
    if (!may_answer(path)) {
      program.operation = to_text(model::Operation::non_real);
      return program;
    }
    bool rejected = false;
    auto answer = ask_program(path, arguments, &rejected);
    // A script, or a program that does not call the init function itself, need not be a process module.
    if (!answer && !rejected && arguments.empty() && !calls_init(path)) return program;
    if (!answer) return answer.problems();
    if (!answer->problems.empty()) return answer->problems;
    program.operation = std::move(answer->operation);
    program.properties = std::move(answer->properties);
    program.ports = std::move(answer->ports);
    program.saved = answer->saved;
    return program;
  }
  if (!arguments.empty())
    return fail("the ports of " + path + " cannot depend on properties, because it is not a program",
                "leave out " + arguments[0]);
  const auto work = [&path]() -> std::string {
    ThreadModule module;
    if (auto loaded = load(module, path, os::Library::Globals::shared, false); !loaded) {
      return model::json_text({{"problems", problems_json(loaded.problems())}});
    }
    return model::json_text(describe_loaded(module, path));
  };
  auto text = os::in_child("loading " + path, work, kLimit);
  if (!text) return text.problems();
  const json answer = model::parse_json(*text);
  if (answer.is_discarded()) return fail("loading " + path + " returned no valid description");
  if (answer.contains("problems")) return problems_from(answer["problems"]);
  auto ports = model::parse_ports(answer["ports"]);
  if (!ports) return ports.problems();
  auto properties = parse_properties(model::json_text(answer["properties"]));
  if (!properties) return properties.problems();
  return Description{.name = answer["name"],
                     .text = component_text(path),
                     .version = component_version(path),
                     .interface = answer["interface"],
                     .operation = {},
                     .hooks = answer["hooks"],
                     .properties = std::move(*properties),
                     .ports = std::move(*ports),
                     .saved = saved_of(answer)};
}

std::string component_text(const std::string& path) {
  const auto section = os::read_section(path, "takt_text");
  return section ? on_one_line(section->c_str()) : "";
}

std::string component_version(const std::string& path) {
  const auto section = os::read_section(path, "takt_version");
  return section ? on_one_line(section->c_str()) : "";
}

namespace {
/// Returns true if one letter of `word` must be changed, added or removed to make it `hook`.
bool differs_in_one_letter(std::string_view word, std::string_view hook) {
  const auto [from_begin, unused] = std::mismatch(word.begin(), word.end(), hook.begin(), hook.end());
  const auto [from_end, also_unused] = std::mismatch(word.rbegin(), word.rend(), hook.rbegin(), hook.rend());
  const auto alike = (from_begin - word.begin()) + (from_end - word.rbegin());
  const auto longer = std::max(word.size(), hook.size());
  return longer <= std::min(word.size(), hook.size()) + 1 && alike + 1 >= static_cast<std::ptrdiff_t>(longer);
}
}  // namespace

Problems misspelt_hooks(const std::string& path) {
  // Short names differ in one letter from functions of the C library, such as stat(), so for these only
  // another case counts.
  constexpr std::array<std::string_view, 6> kHooks{"initialize", "start",   "condition",
                                                   "error",      "recover", "destruct"};
  constexpr std::size_t kLongName = 7;
  if (!os::is_shared_object(path)) return {};
  std::set<std::string> names;
  std::istringstream all{dynamic_names(path)};
  for (std::string name; std::getline(all, name, '\0');) names.insert(name);
  if (names.contains("takt_component_factory") || !names.contains("run")) return {};
  Problems problems;
  for (const std::string_view hook : kHooks) {
    if (names.contains(std::string{hook})) continue;
    for (const std::string& name : names) {
      std::string small = name;
      std::transform(small.begin(), small.end(), small.begin(),
                     [](unsigned char c) { return std::tolower(c); });
      std::erase(small, '_');
      const bool alike = small == hook || (hook.size() >= kLongName && differs_in_one_letter(small, hook));
      if (alike)
        problems.push_back(
            fail("Takt never calls its function " + name + "()",
                 "rename it to " + std::string{hook} + "() if it is the hook, or make it static"));
    }
  }
  return problems;
}

std::vector<ComponentFile> list_components(const std::vector<std::string>& folders) {
  std::map<std::string, ComponentFile> found;
  for (const std::string& folder : folders) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator{folder, error}) {
      const std::string path = entry.path().string();
      const std::string name = entry.path().filename().string();
      ComponentFile file{.path = path, .interface = {}, .text = component_text(path)};
      if (os::is_shared_object(path)) {
        const std::string names = dynamic_names(path);
        const auto has = [&names](const char* symbol) {
          return names.find(std::string{'\0'} + symbol + '\0') != std::string::npos;
        };
        if (has("takt_component_factory"))
          file.interface = "c++";
        else if (has("run"))
          file.interface = "c";
      } else if (os::is_executable(path)) {
        const bool linked = dynamic_names(path).find(kProcessLibrary) != std::string::npos;
        if (linked || !file.text.empty() || entry.path().extension() == ".exe") file.interface = "process";
      }
      if (!file.interface.empty()) found.emplace(name, std::move(file));
    }
  }
  std::vector<ComponentFile> files;
  for (auto& [name, file] : found) files.push_back(std::move(file));
  return files;
}

Result<Components> check_components(const model::Cell& cell, Problems* missing) {
  Problems problems;
  Components found;
  std::vector<ComponentPaths>& paths = found.paths;
  std::map<std::string, std::vector<Use>> thread_modules;
  // For each pair of a program and its arguments, the modules that use this pair. The program is asked for
  // its description once for each pair, because its ports may depend on the properties in the arguments.
  std::map<std::pair<std::string, Arguments>, std::vector<Use>> programs;
  for (std::size_t d = 0; d < cell.devices.size(); ++d) {
    const model::Device& device = cell.devices[d];
    paths.emplace_back();
    found.ports.emplace_back(device.modules.size());
    for (std::size_t m = 0; m < device.modules.size(); ++m) {
      const model::Module& module = device.modules[m];
      auto path = find_component(module.filename, cell.file);
      paths.back().push_back(path ? *path : "");
      if (!path) {
        add_at(cell, module, path.problems(), missing != nullptr ? *missing : problems);
      } else if (module.type == model::ModuleType::process) {
        if (!os::is_executable(*path)) {
          add_at(cell, module,
                 {fail(*path + " is not a program that this user may execute",
                       "build it, or run chmod +x on it")},
                 problems);
        } else if (os::is_shared_object(*path)) {
          add_at(
              cell, module,
              {fail(*path + " is a shared object", "use <moduletype>thread</moduletype>, or name a program")},
              problems);
        } else if (module.operation != model::Operation::non_real && !may_answer(*path)) {
          add_at(cell, module,
                 {fail(std::string{"the program never calls "} + init_function(module.operation) +
                           ", because it is not linked with libtakt_process",
                       "call the function and link the program, or use <operationtype>non-real"
                       "</operationtype>")},
                 problems);
        } else if (module.operation != model::Operation::non_real || calls_init(*path) ||
                   !module.safe.empty() || is_connected(cell, device.name, module.name)) {
          programs[{*path, arguments_of(module)}].push_back({d, m});
        }
      } else if (!os::is_shared_object(*path)) {
        add_at(
            cell, module,
            {fail(*path + " is not a shared object (.so) for this machine",
                  "name one built by takt_add_component; a program needs <moduletype>process</moduletype>")},
            problems);
      } else {
        thread_modules[*path].push_back({d, m});
      }
    }
  }
  for (const auto& [path, uses] : thread_modules) {
    auto text = os::in_child(
        "loading " + path,
        [&file = path, &by = uses, &cell] { return model::json_text(check_uses(file, cell, by)); },
        kLimit);
    const json answer = text ? model::parse_json(*text) : json{};
    for (std::size_t i = 0; i < uses.size(); ++i) {
      const model::Module& module = cell.devices[uses[i].device].modules[uses[i].module];
      if (answer.is_array()) {
        add_at(cell, module, problems_from(answer[i].at("problems")), problems);
        if (answer[i].at("ports").is_null()) continue;
        auto ports = model::parse_ports(answer[i].at("ports"));
        if (ports)
          found.ports[uses[i].device][uses[i].module] = std::move(*ports);
        else
          add_at(cell, module, ports.problems(), problems);
      } else {
        Problem problem =
            text ? fail("loading " + path + " returned no valid description") : text.problems()[0];
        problem.fix =
            "build it again, in case the file is incomplete, and check its constructors, which run when "
            "it is loaded";
        add_at(cell, module, {problem}, problems);
      }
    }
  }
  for (const auto& [started, uses] : programs) {
    const auto answer = ask_program(started.first, started.second);
    for (const Use& use : uses) {
      const model::Module& module = cell.devices[use.device].modules[use.module];
      if (!answer) {
        add_at(cell, module, answer.problems(), problems);
        continue;
      }
      found.ports[use.device][use.module] = answer->ports;
      add_at(cell, module, answer->problems, problems);
      if (!answer->operation.empty())
        add_at(cell, module, module.line, check_operation(module, answer->operation), problems);
    }
  }
  const Problems connections = model::check_connections(cell, found.ports);
  problems.insert(problems.end(), connections.begin(), connections.end());
  if (problems.empty()) return found;
  std::stable_sort(problems.begin(), problems.end(), [](const Problem& a, const Problem& b) {
    const auto line = [](const Problem& p) { return std::stoi(p.where.substr(p.where.rfind(':') + 1)); };
    return line(a) < line(b);
  });
  return problems;
}

Problems misnamed_files(const model::Cell& rejected) {
  std::set<std::pair<std::string_view, std::string_view>> named;  // device and module of each end
  for (const model::Connection& connection : rejected.connections) {
    for (const model::Endpoint* end : {&connection.from, &connection.to})
      named.emplace(end->device, end->module);
  }
  for (const model::Service& service : rejected.services) {
    for (const model::Endpoint* end : {&service.client, &service.server})
      named.emplace(end->device, end->module);
  }
  Problems problems;
  for (const model::Device& device : rejected.devices) {
    for (const model::Module& module : device.modules) {
      const bool meant = std::any_of(named.begin(), named.end(), [&](const auto& end) {
        return end.first == device.name && end.second != module.name &&
               !nearest(end.second, {module.name}).empty();
      });
      if (module.lines.name.given() || !meant) continue;
      const auto path = find_component(module.filename, rejected.file);
      if (!path) add_at(rejected, module, path.problems(), problems);
    }
  }
  return problems;
}

}  // namespace takt::host
