// Runs a descriptor on this machine: one takt-node for each device, all from one instant.
#include <algorithm>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include <takt/node/control.hpp>
#include <takt/node/log.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>

#include "commands.hpp"
#include "load.hpp"
#include "run_report.hpp"
#include "terminal.hpp"

namespace takt::tool {

namespace {

using json = nlohmann::ordered_json;

/// One device's node, seen from here.
struct Node {
  std::string device;
  os::Child process;
  os::MessageSocket control;
  bool ready = false;
  bool ended = false;
  json report;
  std::vector<std::string> failures;

  void tell(const json& message) { control.send(message.dump()); }
};

class Cell {
 public:
  explicit Cell(const RunOptions& options) : options_(options) {}

  Result<void> start(const model::Cell& cell);
  /// Until every node has ended.
  void serve(const os::SignalQueue& signals);
  json report(const std::string& cell) const;
  [[nodiscard]] std::vector<std::string> failures() const;
  /// Whether the first row was agreed; else there is nothing to report but why not.
  [[nodiscard]] bool went() const noexcept { return went_; }

 private:
  void take_messages(Node& node);
  void watch_end(Node& node);
  void stop();
  [[nodiscard]] int milliseconds_left() const {
    if (!end_at_ || stopping_) return 20;
    return static_cast<int>(
        std::min<std::int64_t>((*end_at_ - os::now()) / std::chrono::milliseconds{1}, 20));
  }
  bool all(bool Node::*flag) const {
    for (const auto& node : nodes_) {
      if (!((*node).*flag)) return false;
    }
    return true;
  }

  const RunOptions& options_;
  std::vector<std::unique_ptr<Node>> nodes_;
  bool went_ = false;
  bool stopping_ = false;
  std::optional<Instant> end_at_;
};

Result<void> Cell::start(const model::Cell& cell) {
  for (const model::Device& device : cell.devices) {
    auto sockets = os::MessageSocket::pair();
    if (!sockets) return sockets.problems();
    auto node = std::make_unique<Node>();
    node->device = device.name;
    node->control = std::move(sockets->first);
    os::MessageSocket theirs = std::move(sockets->second);
    os::SpawnOptions spawn{.program = os::program_directory() + "/takt-node",
                           .arguments = {"--device", device.name, "--file", cell.file},
                           .environment = {{node::kControlFd, std::to_string(theirs.fd().get())}},
                           .inherit = {&theirs.fd()},
                           .dies_with_parent = false};  // it ends in order when the socket does
    if (options_.require_real_time) spawn.arguments.emplace_back("--require-realtime");
    if (options_.quiet) spawn.arguments.emplace_back("--quiet");
    auto process = os::Child::spawn(spawn);
    if (!process) return process.problems();
    node->process = std::move(*process);
    nodes_.push_back(std::move(node));
  }
  return {};
}

void Cell::serve(const os::SignalQueue& signals) {
  while (!all(&Node::ended)) {
    std::vector<const os::Fd*> fds{&signals.fd()};
    for (const auto& node : nodes_) {
      if (!node->control.closed()) fds.push_back(&node->control.fd());
    }
    os::wait_readable(fds, std::clamp(milliseconds_left(), 0, 20));

    while (signals.next()) {
      if (stopping_) {
        for (auto& node : nodes_) node->process.signal(os::kKill);  // asked a second time
      }
      stop();
    }
    for (auto& node : nodes_) {
      take_messages(*node);
      watch_end(*node);
    }
    if (!went_ && !stopping_ && all(&Node::ready)) {
      went_ = true;
      const Instant t0 = os::now() + std::chrono::milliseconds{50};
      for (auto& node : nodes_) node->tell({{"do", "go"}, {"t0", to_ns(t0)}});
      if (options_.seconds) {
        end_at_ =
            t0 + std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(*options_.seconds));
      }
    }
    if (end_at_ && os::now() >= *end_at_) stop();
  }
}

void Cell::take_messages(Node& node) {
  while (auto text = node.control.receive()) {
    const json message = json::parse(*text, nullptr, false);
    const std::string event = message.value("event", "");
    if (event == "ready") node.ready = true;
    if (event != "ended") continue;
    node.report = message.at("report");
    node.failures = message.at("failures").get<std::vector<std::string>>();
    if (!went_) stop();  // all devices reach START, or none runs
  }
}

void Cell::watch_end(Node& node) {
  const auto end = node.process.poll();
  if (!end) return;
  take_messages(node);
  node.ended = true;
  if (!node.report.is_null()) return;
  // It had no time for a report: refused at once with a reason of its own, or killed.
  node.report = {{"name", node.device},
                 {"alive", false},
                 {"real_time", false},
                 {"executors", json::array()},
                 {"modules", json::array()}};
  if (went_ && !options_.quiet)
    node::log(node.device, "", "its node " + end->text() + "; the other devices run on");
  if (end->signalled || end->code == 0 || went_)
    node.failures.push_back("device " + node.device + ": error: its node " + end->text());
  else
    node.failures.push_back("device " + node.device + ": error: its node refused to run it, see above");
  if (!went_) stop();
}

void Cell::stop() {
  if (stopping_) return;
  stopping_ = true;
  for (auto& node : nodes_) {
    if (!node->ended) node->tell({{"do", "stop"}});
  }
}

json Cell::report(const std::string& cell) const {
  json devices = json::array();
  for (const auto& node : nodes_) devices.push_back(node->report);
  return {{"cell", cell}, {"devices", devices}};
}

std::vector<std::string> Cell::failures() const {
  std::vector<std::string> all;
  for (const auto& node : nodes_) all.insert(all.end(), node->failures.begin(), node->failures.end());
  return all;
}

}  // namespace

int run(const RunOptions& options) {
  const auto loaded = load(options.file);
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  os::survive_broken_pipes();
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) {
    complain(signals.problems());
    return 1;
  }
  Cell cell{options};
  if (const auto started = cell.start(loaded->cell); !started) {
    complain(started.problems());
    return 1;
  }
  cell.serve(*signals);

  const json report = cell.report(loaded->cell.name);
  const bool printed = print(options.json ? report.dump() + "\n" : cell.went() ? run_text(report) : "");
  const auto failures = cell.failures();
  for (const std::string& failure : failures) std::fprintf(stderr, "%s\n", failure.c_str());
  return failures.empty() && printed ? 0 : 1;
}

}  // namespace takt::tool
