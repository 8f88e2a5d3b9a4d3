// takt complete: prints the names that the shell offers as completions. The command is hidden, because only
// the completion script calls it.
#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/model/validate.hpp>

#include "commands/commands.hpp"
#include "commands/network_options.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

// Upper limits of the time that the user waits after pressing the tab key.
constexpr milliseconds kFirstDevice{600};
constexpr milliseconds kOtherDevices{250};
constexpr milliseconds kDescribed{1000};

std::string name_in(const Json& value) { return value.at("name").get<std::string>(); }

/// Returns true if the port, NAME/request or NAME/reply, belongs to a service that can be called.
bool is_of_service(const Json& port) {
  const auto role = port.find("role");
  return role != port.end() && (*role == "service" || *role == "handler");
}

/// Asks all devices at the same time for their modules, and returns the modules by device. The result has no
/// entry for a device that does not answer in time; such a device usually answers the next request at once.
std::map<std::string, Json> described(client::Operator& sender, const std::vector<std::string>& devices) {
  std::vector<client::CommandRequest> requests;
  for (const std::string& device : devices)
    requests.push_back({.kind = COMMAND_DESCRIBE, .device = device, .limit = kDescribed});
  auto answers = sender.send(requests);
  std::map<std::string, Json> modules;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = client::accepted(std::move(answers[i]));
    if (!answer) continue;
    if (auto described = client::described_modules(devices[i], answer->data))
      modules[devices[i]] = *described;
  }
  return modules;
}

/// Returns the names of one kind. The result is empty if no device is found in time.
std::set<std::string> names_of(const std::string& kind, const std::string& word, const std::string& target,
                               const client::Network& network) {
  const auto client = client::connect(network);
  if (!client) return {};
  const client::Observer& observer = *client->observer;
  const auto any_alive = [](const auto& seen) {
    return std::any_of(seen.begin(), seen.end(), [](const auto& device) { return device.alive; });
  };
  if (!observer.wait(any_alive, kFirstDevice)) return {};
  observer.settle(kOtherDevices);

  std::set<std::string> names;
  // A node may send any text as a name, and the shell runs the completed line. So accept only valid names.
  const auto add = [&names](const std::string& device, const std::string& module, const std::string& last) {
    std::string name;
    for (const std::string* part : {&device, &module, &last}) {
      if (part->empty()) continue;
      if (!model::is_valid_name(*part)) return;
      name += (name.empty() ? "" : ".") + *part;
    }
    names.insert(name);
  };
  std::vector<std::string> asked;
  for (const wire::ObservedDevice& seen : observer.devices()) {
    if (!seen.alive) continue;
    const std::string device = seen.name();
    if (kind == "devices" || kind == "targets") add(device, "", "");
    if (kind == "modules" || kind == "targets") {
      for (const auto& [module, status] : seen.deployment.modules) add(device, module, "");
    }
    const std::string begin = (kind == "properties" ? target : word).substr(0, device.size() + 1);
    if ((kind == "ports" || kind == "services" || kind == "properties") && (device + ".").starts_with(begin))
      asked.push_back(device);
  }
  for (const auto& [device, modules] : described(*client->sender, asked)) {
    for (const Json& module : modules) {
      if (kind == "ports") {
        for (const Json& port : module.at("ports")) add(device, name_in(module), name_in(port));
      }
      if (kind == "services") {
        for (const Json& port : module.at("ports")) {
          const std::string name = name_in(port);
          if (is_of_service(port)) add(device, name_in(module), name.substr(0, name.find('/')));
        }
      }
      if (kind == "properties" && device + "." + name_in(module) == target) {
        for (const Json& property : module.at("properties")) add(name_in(property), "", "");
      }
    }
  }
  return names;
}

}  // namespace

void add_complete(CLI::App& app, Chosen& chosen) {
  auto kind = std::make_shared<std::string>();
  auto word = std::make_shared<std::string>();
  auto target = std::make_shared<std::string>();
  auto network = std::make_shared<client::Network>();
  auto* command = app.add_subcommand("complete", "Print the names that the shell can complete");
  command->group("");  // hides it from --help, the manual and the completion
  command->add_option("KIND", *kind, "devices, modules, targets (both), ports, services or properties")
      ->required();
  command->add_option("WORD", *word, "the beginning of the name, which may be empty");
  command->add_option("TARGET", *target, "for properties: DEVICE.MODULE");
  add_network_options(*command, *network);
  command->callback([=, &chosen] {
    chosen = [=] {
      std::string lines;
      for (const std::string& name : names_of(*kind, *word, *target, *network)) lines += name + "\n";
      return lines.empty() || print(lines) ? 0 : 1;
    };
  });
}

}  // namespace takt::tool
