#include <takt/node/inspection.hpp>

#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include <takt/agent/problems_json.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/host/component_path.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

namespace takt::node {

using agent::Inspected;
using agent::Inspection;
using agent::InspectionRequest;
using agent::problems_from;
using agent::problems_json;

namespace {

using json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// The time limit for all components of a device. Each component also has its own limit.
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

// Describes a component with the ports that the check found, because the ports of a program may depend on its
// properties. A program that the check did not query is not queried here, because it may be unable to answer.
json describe(const model::Module& module, const std::string& path, const model::ModulePorts& ports) {
  json entry{{"name", module.name}, {"path", path}};
  entry["ports"] = ports ? model::parse_json(model::ports_json(*ports)) : json(nullptr);
  if (module.type == model::ModuleType::process && !ports) {
    entry["interface"] = "process";
    return entry;
  }
  const auto found = host::describe(path);
  if (!found) return entry;
  const json description = model::parse_json(host::to_json(*found));
  entry["component"] = found->name;
  for (const char* member : {"text", "interface", "operation", "hooks", "properties"})
    entry[member] = description[member];
  return entry;
}

// Finds the file of a component on this device's component path. Only the file name is used, because the
// descriptor may come from another machine.
Result<std::string> on_component_path(const std::string& filename) {
  const std::string name = fs::path{filename}.filename().string();
  std::string tried;
  for (const std::string& folder : host::component_folders()) {
    std::error_code error;
    const fs::path path = fs::absolute(fs::path{folder} / name, error).lexically_normal();
    if (fs::is_regular_file(path, error)) return path.string();
    tried += (tried.empty() ? "" : ", ") + folder;
  }
  return fail("there is no file " + name + " on this device's component path (" + tried + ")",
              "copy it to one of these folders, or add its folder to TAKT_COMPONENT_PATH of takt-node");
}

json inspect_here(const InspectionRequest& request) {
  const auto refuse = [](const Problems& problems) { return json{{"problems", problems_json(problems)}}; };
  auto cell = descriptor::parse(request.text, request.file);
  if (!cell) return refuse(cell.problems());
  const auto device = std::find_if(cell->devices.begin(), cell->devices.end(),
                                   [&](const model::Device& d) { return d.name == request.device; });
  if (device == cell->devices.end()) return refuse({fail("there is no device " + request.device)});

  // Only this device is checked. Modules whose file is missing are left out.
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
      if (auto path = on_component_path(module.filename); path) {
        module.filename = *path;
        found.push_back(module);
      } else {
        for (const Problem& problem : path.problems()) {
          problems.push_back(model::problem_at(cell->texts(), module.line,
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
  json answer{{"paths", components->paths.at(0)}, {"ports", ports}};
  if (!request.describe) return answer;
  json modules = json::array();
  for (std::size_t i = 0; i < mine.devices[0].modules.size(); ++i)
    modules.push_back(
        describe(mine.devices[0].modules[i], components->paths.at(0)[i], components->ports.at(0)[i]));
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
