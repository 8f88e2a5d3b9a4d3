// takt run: runs a cell on this machine. Starts one takt-node for each device, and deploys the cell to these
// nodes as `takt deploy` does.
#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/deploy.hpp>
#include <takt/model/profile_json.hpp>
#include <takt/node/log.hpp>
#include <takt/node/node.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/keeper.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/output_file.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

#include "commands/bring_up.hpp"
#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "reports/profile_report.hpp"
#include "reports/run_report.hpp"
#include "reports/violations_report.hpp"
#include "terminal/progress.hpp"
#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

struct RunOptions {
  std::string file;
  client::Network network;
  std::optional<double> seconds;  ///< how long to run; by default until Ctrl-C
  bool json = false;
  bool require_real_time = false;
  bool check_real_time = false;  ///< make the run fail if a module breaks the rules of real-time code
  bool quiet = false;
  std::string state_folder;  ///< the folder of the fault records; if empty, they are in memory
  std::string profile;       ///< the file for the run times at the end; if empty, they are not written
};

/// What this program knows about the node of one device.
struct Node {
  std::string device;
  os::Child process;
  int pid = 0;
  os::MessageSocket lifetime;  ///< the node shuts down cleanly when this socket closes
  bool ended = false;          ///< the node's process has ended
  bool reported = false;       ///< the node's closing report, or the reason for its end, is known
  Json report{};
  std::vector<std::string> failures{};
};

class Run {
 public:
  Run(const RunOptions& options, const Loaded& loaded, const os::SignalQueue& signals)
      : options_(options), loaded_(loaded), signals_(signals) {}

  Result<void> start_nodes(int domain);
  Result<void> deploy(const client::Connection& client);
  /// Lets the cell run until the time is over, a signal asks for the end, or every device has ended.
  void serve(const client::Connection& client);
  /// Takes the cell down on the devices that are still running.
  void undeploy(const client::Connection& client);
  void end_nodes();

  [[nodiscard]] Json report() const;
  [[nodiscard]] std::vector<std::string> failures() const;
  /// True if the nodes agreed on the time of the first row. Otherwise the cell never ran.
  [[nodiscard]] bool started() const noexcept { return started_; }

 private:
  void watch();
  void note(const client::Undeployed& undeployed);
  void ask_one(const client::Connection& client, Node& node);
  [[nodiscard]] std::map<std::string, std::int32_t> process_ids() const;
  [[nodiscard]] client::Devices still_running() const;

  const RunOptions& options_;
  const Loaded& loaded_;
  const os::SignalQueue& signals_;
  std::vector<std::unique_ptr<Node>> nodes_;
  bool started_ = false;
  std::string deployment_;  // id of the deployment; empty until the cell runs
  bool asked_to_end_ = false;
  bool undeploying_ = false;
  std::optional<Instant> end_at_;
};

Result<void> Run::start_nodes(int domain) {
  const model::Discovery discovery = client::discovery_of(options_.network, &loaded_.cell);
  for (const model::Device& device : loaded_.cell.devices) {
    auto sockets = os::MessageSocket::pair();
    if (!sockets) return sockets.problems();
    auto node = std::make_unique<Node>();
    node->device = device.name;
    node->lifetime = std::move(sockets->first);
    const os::MessageSocket theirs = std::move(sockets->second);
    os::SpawnOptions spawn{.program = os::program_directory() + "/takt-node",
                           .arguments = {"--device", device.name, "--domain", std::to_string(domain)},
                           .environment = {{node::kLifetimeFd, std::to_string(theirs.fd().get())}},
                           .inherit = {&theirs.fd()},
                           .dies_with_parent = false};  // the node shuts down cleanly when the socket closes
    const auto add = [&spawn](const std::string& option, const std::string& value) {
      spawn.arguments.push_back(option);
      spawn.arguments.push_back(value);
    };
    if (discovery.kind == model::Discovery::Kind::peers) {
      std::string peers;
      for (const std::string& peer : discovery.peers) peers += (peers.empty() ? "" : ",") + peer;
      add("--peers", peers);
    }
    if (discovery.kind == model::Discovery::Kind::server) {
      add("--server", discovery.server);
      if (device.name == loaded_.cell.server_device)
        add("--serve-discovery", discovery.server.substr(discovery.server.rfind(':') + 1));
    }
    if (const std::string security = client::security_of(options_.network); !security.empty())
      add("--security", security);
    if (options_.require_real_time) spawn.arguments.emplace_back("--require-realtime");
    if (options_.check_real_time) spawn.arguments.emplace_back("--check-realtime");
    if (!options_.state_folder.empty()) add("--state-dir", options_.state_folder);
    if (options_.quiet) spawn.arguments.emplace_back("--quiet");
    auto process = os::Child::spawn(spawn);
    if (!process) return process.problems();
    node->process = std::move(*process);
    node->pid = node->process.pid();
    nodes_.push_back(std::move(node));
  }
  return {};
}

std::map<std::string, std::int32_t> Run::process_ids() const {
  std::map<std::string, std::int32_t> ids;
  for (const auto& node : nodes_) ids[node->device] = node->pid;
  return ids;
}

// Handles Ctrl-C, SIGTERM, and nodes whose process has ended. All functions that wait for something call
// watch() repeatedly.
void Run::watch() {
  while (signals_.next()) {
    if (asked_to_end_) {
      for (auto& node : nodes_) node->process.signal(os::kKill);  // a second signal kills the nodes
    }
    asked_to_end_ = true;
  }
  for (auto& pointer : nodes_) {
    Node& node = *pointer;
    const auto end = node.process.poll();
    if (!end) continue;
    node.ended = true;
    if (node.reported) continue;
    // The node ended without a report. Either it rejected the cell and printed the reason, or it was killed.
    node.reported = true;
    if (started_ && !undeploying_ && !options_.quiet)
      node::log(node.device, "", "its node " + end->text() + "; the other devices continue");
    const bool rejected = !end->signalled && end->code != 0 && !started_;
    node.failures.push_back("device " + node.device + ": error: its node " +
                            (rejected ? "rejected the cell; see the reason above" : end->text()));
  }
}

Result<void> Run::deploy(const client::Connection& client) {
  std::vector<client::Undeployed> undone;
  // Show the progress only with --quiet. Without --quiet, the nodes print their events on the same terminal.
  std::optional<BringUpProgress> bring_up;
  if (options_.quiet) bring_up.emplace(client, loaded_.cell);
  client::DeployOptions deploy{.require_real_time = options_.require_real_time,
                               .process_ids = process_ids(),
                               .progress = {},
                               .cancelled =
                                   [this, &bring_up] {
                                     watch();
                                     if (bring_up) bring_up->refresh();
                                     return asked_to_end_ ||
                                            std::any_of(nodes_.begin(), nodes_.end(),
                                                        [](const auto& n) { return n->ended; });
                                   },
                               .undone = &undone};
  const auto deployed = client::deploy(*client.sender, loaded_.cell, loaded_.text, deploy);
  if (bring_up) bring_up->end(deployed.ok());
  for (const client::Undeployed& one : undone) note(one);
  if (!deployed) {
    watch();
    for (auto& node : nodes_) node->reported = true;
    // Print the reason only if the user does not know it already. The user knows the reason after asking
    // `takt run` to end, or if the failure of a node was printed.
    const bool known = asked_to_end_ || std::any_of(nodes_.begin(), nodes_.end(), [](const auto& node) {
                         return node->ended && !node->failures.empty();
                       });
    return known ? Result<void>{} : deployed.problems();
  }
  started_ = true;
  deployment_ = deployed->id;
  const Instant t0 = os::instant_of_wall(deployed->t0_ns);
  if (options_.seconds) {
    end_at_ = t0 + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(*options_.seconds));
  }
  return {};
}

void Run::note(const client::Undeployed& undeployed) {
  for (auto& node : nodes_) {
    if (node->device != undeployed.device || node->ended || !undeployed.problems.empty()) continue;
    node->reported = true;
    node->report = undeployed.report;
    node->failures = undeployed.failures;
  }
}

client::Devices Run::still_running() const {
  client::Devices devices{.names = {}, .process_ids = process_ids(), .deployment = deployment_};
  for (const auto& node : nodes_) {
    if (!node->reported) devices.names.push_back(node->device);
  }
  return devices;
}

void Run::serve(const client::Connection& client) {
  Progress progress;
  while (!asked_to_end_ && !(end_at_ && os::now() >= *end_at_)) {
    if (options_.quiet && end_at_ && progress.is_due()) {
      const double left = std::chrono::duration<double>(*end_at_ - os::now()).count();
      const double passed = std::max(0.0, *options_.seconds - left);
      progress.show(share_text(passed / *options_.seconds,
                               fmt::format("{:.0f} of {} s", passed, *options_.seconds),
                               {.unicode = is_utf8()}));
    }
    std::int64_t limit = 20;
    if (end_at_)
      limit = std::clamp<std::int64_t>((*end_at_ - os::now()) / std::chrono::milliseconds{1}, 0, limit);
    os::wait_readable({&signals_.fd()}, static_cast<int>(limit));
    watch();
    bool all = true;
    for (auto& node : nodes_) {
      if (!node->reported) ask_one(client, *node);
      all &= node->reported;
    }
    if (all) return;
  }
}

// Checks whether a device has ended by itself. If so, fetches its report and ends its node.
void Run::ask_one(const client::Connection& client, Node& node) {
  for (const wire::ObservedDevice& seen : client.observer->devices(node.device)) {
    if (!seen.alive || seen.status.process_id() != node.pid || seen.status.state() != DEVICE_ENDED) continue;
    client::Devices one{
        .names = {node.device}, .process_ids = {{node.device, node.pid}}, .deployment = deployment_};
    for (const auto& undeployed : client::undeploy(*client.sender, one, [this] { watch(); }))
      note(undeployed);
    node.lifetime.close();
    return;
  }
}

void Run::undeploy(const client::Connection& client) {
  undeploying_ = true;
  for (const auto& undeployed : client::undeploy(*client.sender, still_running(), [this] { watch(); }))
    note(undeployed);
}

void Run::end_nodes() {
  for (auto& node : nodes_) node->lifetime.close();
  while (std::any_of(nodes_.begin(), nodes_.end(), [](const auto& node) { return !node->ended; })) {
    os::wait_readable({&signals_.fd()}, 2);
    watch();
  }
}

Json Run::report() const {
  Json devices = Json::array();
  for (const auto& node : nodes_) {
    const Json nothing{{"name", node->device},
                       {"alive", false},
                       {"real_time", false},
                       {"executors", Json::array()},
                       {"modules", Json::array()}};
    devices.push_back(node->report.is_object() ? node->report : nothing);
  }
  return {{"cell", loaded_.cell.name}, {"devices", devices}};
}

std::vector<std::string> Run::failures() const {
  std::vector<std::string> all;
  for (const auto& node : nodes_) all.insert(all.end(), node->failures.begin(), node->failures.end());
  return all;
}

/// The properties of this machine that affect run times.
std::map<std::string, std::string> machine() {
  std::map<std::string, std::string> facts{{"host", os::host_name()},
                                           {"processors", std::to_string(os::read_cpus().permitted.size())}};
  std::getline(std::ifstream{"/proc/sys/kernel/osrelease"}, facts["kernel"]);
  std::ifstream processors{"/proc/cpuinfo"};
  for (std::string line; std::getline(processors, line) && facts["processor"].empty();) {
    if (line.starts_with("model name")) facts["processor"] = line.substr(line.find(':') + 2);
  }
  return facts;
}

int run(const RunOptions& options) {
  os::run_below_first_process();
  const auto loaded = load(options.file);
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  const auto domain = client::domain_of(options.network, &loaded->cell);
  if (!domain) {
    complain(domain.problems());
    return 1;
  }
  if (const std::string note = client::domain_note(options.network, loaded->cell); !note.empty()) tell(note);
  os::survive_broken_pipes();
  // Block the signals before any thread starts, because new threads inherit the set of blocked signals.
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) {
    complain(signals.problems());
    return 1;
  }
  Run run{options, *loaded, *signals};
  Problems problems;
  const auto keep = [&problems](const auto& result) {
    if (!result) problems = result.problems();
    return result.ok();
  };
  if (keep(run.start_nodes(*domain))) {
    client::Network network = options.network;
    network.domain = *domain;
    const auto client = client::connect(network, &loaded->cell);
    if (keep(client) && keep(run.deploy(*client)) && run.started()) {
      run.serve(*client);
      run.undeploy(*client);
    }
  }
  run.end_nodes();

  Json report = run.report();
  leave_out_components(report);
  if (run.started() && !options.profile.empty()) {
    const auto written =
        os::write_output(options.profile, model::profile_json(profile_of(report), machine()));
    if (!written) problems.insert(problems.end(), written.problems().begin(), written.problems().end());
  }
  const bool printed = print(options.json    ? run_json(report)
                             : run.started() ? run_text(report) + violations_text(report)
                                             : "");
  if (!problems.empty()) complain(problems);
  const auto failures = run.failures();
  for (const std::string& failure : failures) {
    const bool printed_above = std::any_of(problems.begin(), problems.end(), [&](const Problem& problem) {
      return to_text(problem) == failure;
    });
    if (!printed_above) tell(failure);
  }
  return problems.empty() && failures.empty() && printed ? 0 : 1;
}

}  // namespace

void add_run(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<RunOptions>();
  auto* command = app.add_subcommand(
      "run", "Run a descriptor on this machine, one takt-node for each device, until Ctrl-C");
  command->add_option("FILE", options->file, "a cell, or a module.xml")->required();
  command->add_option("--for", options->seconds, "end after this many seconds")
      ->type_name("SECONDS")
      ->check(positive_seconds());
  command->add_flag("--json", options->json, "print the closing report as one JSON object");
  command->add_flag("--require-realtime", options->require_real_time,
                    "fail if the system denies real-time scheduling");
  command
      ->add_option("--profile", options->profile,
                   "when the run ends, write the run times of each module to this file")
      ->type_name("OUT");
  command
      ->add_option("--state-dir", options->state_folder,
                   "keep the fault record of each device in this folder (default: in memory, for this run)")
      ->type_name("DIR");
  command->add_flag(
      "--check-realtime", options->check_real_time,
      "report every allocation, lock, system call and page fault in a module's run() or "
      "condition(), with the calls that led to it; exit with 1 if there were any. The run is slower");
  command->add_flag("--quiet", options->quiet,
                    "print only the closing report, without a line for each event");
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace takt::tool
