#include <takt/node/inspection.hpp>

#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include <takt/agent/problems_json.hpp>
#include <takt/core/log_level.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/host/component_path.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>
#include <takt/security/hash.hpp>

namespace takt::node {

using agent::Inspected;
using agent::Inspection;
using agent::InspectionRequest;
using agent::problems_from;
using agent::problems_json;

namespace {

using json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// The time limit for inspecting all components of a device. There is also a shorter limit for each
/// component.
constexpr Nanoseconds kLimit = std::chrono::seconds{60};

class InspectionProgram final : public Inspection {
 public:
  static Result<std::unique_ptr<Inspection>> start(const InspectionRequest& request) {
    auto sockets = os::MessageSocket::pair();
    if (!sockets) return sockets.problems();
    auto program = std::make_unique<InspectionProgram>();
    program->socket_ = std::move(sockets->first);
    const os::MessageSocket theirs = std::move(sockets->second);
    auto child = os::Child::spawn({.program = os::program_directory() + "/takt-node",
                                   .environment = {{kInspectFd, std::to_string(theirs.fd().get())}},
                                   .inherit = {&theirs.fd()}});
    if (!child) return child.problems();
    program->child_ = std::move(*child);
    program->begun_ = os::now();
    program->socket_.send(model::json_text({{"text", request.text},
                                            {"file", request.file},
                                            {"device", request.device},
                                            {"as_written", request.as_written},
                                            {"describe", request.describe},
                                            {"only", request.only},
                                            {"swapped", request.swapped}}));
    return {std::move(program)};
  }

  std::optional<Result<Inspected>> result() override {
    socket_.flush();
    if (const auto text = socket_.receive()) return read(*text);
    if (socket_.closed()) return failed("ended without an answer");
    if (os::now() - begun_ > kLimit) return failed("gave no answer within " + to_text(kLimit));
    return std::nullopt;
  }

 private:
  static Result<Inspected> failed(const std::string& how) {
    return fail("the process that inspects the components " + how,
                "check the constructors of the components");
  }

  static Result<Inspected> read(const std::string& text) {
    const json answer = model::parse_json(text);
    if (answer.is_discarded()) return failed("gave an answer that cannot be read");
    if (answer.contains("problems")) return problems_from(answer["problems"]);
    Inspected inspected{.paths = answer.at("paths").get<host::ComponentPaths>()};
    if (answer.contains("description")) inspected.description = model::json_text(answer["description"]);
    for (const json& build : answer.at("builds"))
      inspected.builds.push_back({.version = build.at("version"), .hash = build.at("hash")});
    for (const json& module : answer.at("ports")) {
      inspected.ports.emplace_back();
      if (module.is_null()) continue;
      auto ports = model::parse_ports(module.get<std::string>());
      if (!ports) return ports.problems();
      inspected.ports.back() = std::move(*ports);
    }
    return inspected;
  }

  os::MessageSocket socket_;
  os::Child child_;
  Instant begun_{};
};

/// The property that every module with a log has. The node keeps its value.
json log_level_property() {
  json choices = json::array();
  for (const LogLevel level : {LogLevel::error, LogLevel::warning, LogLevel::info, LogLevel::debug})
    choices.push_back(takt::to_text(level));
  return {{"name", kLogLevelProperty},
          {"type", "string"},
          {"default", takt::to_text(kDefaultLogLevel)},
          {"range", "error, warning, info or debug"},
          {"choices", choices},
          {"min", nullptr},
          {"max", nullptr},
          {"unit", ""},
          {"text", "The least important log lines that are recorded."}};
}

// Describes a component for the answer. `ports` are the ports that check_components() found with the module's
// properties, because the ports of a program may depend on the properties. If check_components() did not ask
// a program for its ports, this function does not ask the program either, because such a program may be
// unable to answer.
json describe(const model::Module& module, const std::string& path, const json& build,
              const model::ModulePorts& ports) {
  json entry{{"name", module.name}, {"path", path}};
  entry.update(build);
  entry["ports"] = ports ? model::parse_json(model::ports_json(*ports)) : json(nullptr);
  if (module.type == model::ModuleType::process && !ports) {
    entry["interface"] = "process";
  } else if (const auto found = host::describe(path)) {
    const json description = model::parse_json(host::to_json(*found));
    entry["component"] = found->name;
    for (const char* member : {"text", "interface", "operation", "hooks", "properties"})
      entry[member] = description[member];
  }
  if (model::has_log(module)) entry["properties"].push_back(log_level_property());
  return entry;
}

json inspect_here(const InspectionRequest& request) {
  const auto refuse = [](const Problems& problems) { return json{{"problems", problems_json(problems)}}; };
  auto cell = descriptor::parse(request.text, request.file);
  if (!cell) return refuse(cell.problems());
  const auto device = std::find_if(cell->devices.begin(), cell->devices.end(),
                                   [&](const model::Device& d) { return d.name == request.device; });
  if (device == cell->devices.end()) return refuse({fail("there is no device " + request.device)});

  // Check only the modules of this device. A module whose file is missing is reported and not checked.
  model::Cell mine = *cell;
  mine.devices = {*device};
  if (!request.only.empty()) {
    std::erase_if(mine.devices[0].modules, [&](const model::Module& m) { return m.name != request.only; });
    mine.connections.clear();
  }
  for (model::Module& module : mine.devices[0].modules) {
    if (const auto file = request.swapped.find(module.name); file != request.swapped.end())
      module.filename = file->second;
  }
  Problems problems;
  if (!request.as_written) {
    std::vector<model::Module> found;
    for (model::Module& module : mine.devices[0].modules) {
      if (auto path = host::find_on_component_path(module.filename); path) {
        module.filename = *path;
        found.push_back(module);
      } else {
        for (const Problem& problem : path.problems()) {
          problems.push_back(model::problem_at(cell->texts(), model::line_of_file(module),
                                               "module " + module.name + ": " + problem.what, problem.fix));
        }
      }
    }
    mine.devices[0].modules = std::move(found);
  }
  auto components = host::check_components(mine);
  if (!components)
    problems.insert(problems.end(), components.problems().begin(), components.problems().end());
  if (!problems.empty()) {
    for (Problem& problem : problems) problem.what = "device " + request.device + ": " + problem.what;
    return refuse(problems);
  }

  json ports = json::array();
  for (const model::ModulePorts& module : components->ports.at(0))
    ports.push_back(module ? json(model::ports_json(*module)) : json(nullptr));
  json builds = json::array();
  std::map<std::string, json> known;  // by path, because several modules may use one file, which is then read
                                      // only once
  for (const std::string& path : components->paths.at(0)) {
    json& build = known[path];
    if (build.is_null())
      build = {{"version", host::component_version(path)}, {"hash", security::short_hash(path)}};
    builds.push_back(build);
  }
  json answer{{"paths", components->paths.at(0)}, {"builds", builds}, {"ports", ports}};
  if (!request.describe) return answer;
  json modules = json::array();
  for (std::size_t i = 0; i < mine.devices[0].modules.size(); ++i)
    modules.push_back(describe(mine.devices[0].modules[i], components->paths.at(0)[i], builds[i],
                               components->ports.at(0)[i]));
  answer["description"] = {{"device", request.device}, {"modules", modules}};
  return answer;
}

}  // namespace

Result<std::unique_ptr<Inspection>> inspect(const InspectionRequest& request) {
  return InspectionProgram::start(request);
}

int run_inspection() {
  os::survive_broken_pipes();
  os::MessageSocket node{os::take_fd_from_environment(kInspectFd)};
  const auto text = node.receive_wait();
  const json request = text ? model::parse_json(*text) : json{};
  if (!request.is_object()) return 1;
  node.send_wait(model::json_text(inspect_here({.text = request.at("text"),
                                                .file = request.at("file"),
                                                .device = request.at("device"),
                                                .as_written = request.at("as_written"),
                                                .describe = request.at("describe"),
                                                .only = request.at("only"),
                                                .swapped = request.at("swapped")})));
  return 0;
}

}  // namespace takt::node
