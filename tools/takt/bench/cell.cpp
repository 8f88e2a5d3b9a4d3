// takt bench cell: measures the deployment of a cell and the transfer of samples between devices.
#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>

#include "bare_dds.hpp"
#include "benchmarks.hpp"
#include "drawing/canvas.hpp"
#include "measured_cell.hpp"
#include "programs.hpp"
#include "scratch_folder.hpp"

namespace takt::bench {

namespace {

using json = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr double kCellSeconds = 10;
constexpr Nanoseconds kCellPeriod = 10ms;
constexpr Nanoseconds kCellFound = 60s;  // time limit for the discovery of all nodes

std::string device_name(int device) { return fmt::format("bench{}", device); }
std::string recording_name(int device, int pair) { return fmt::format("ages{}_{}", device, pair); }

std::string descriptor_of(const CellSettings& cell, Nanoseconds period, std::size_t samples,
                          const ScratchFolder& folder) {
  std::string text = "<cell name=\"bench\">\n";
  for (int device = 0; device < cell.devices; ++device) {
    text += fmt::format("  <device name=\"{}\">\n", device_name(device));
    for (int pair = 0; pair < cell.pairs; ++pair) {
      text += fmt::format(
          R"(    <module><name>sender{0}</name><filename>bench_sender.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>{1}</period><priority>{0}</priority></module>
    <module><name>receiver{0}</name><filename>bench_receiver.so</filename><moduletype>thread</moduletype>
      <operationtype>sporadic</operationtype><deadline>{1}</deadline><priority>{0}</priority><dispatch>immediate</dispatch>
      <property><value name="file">{2}</value><value name="samples">{3}</value></property></module>
)",
          pair, period.count(), tool::escaped(folder.file(recording_name(device, pair))), samples);
    }
    text += "  </device>\n";
  }
  for (int device = 0; device < cell.devices; ++device) {
    for (int pair = 0; pair < cell.pairs; ++pair) {
      text += fmt::format(
                  R"(  <connection from="{}.sender{}.out" to="{}.receiver{}.in" kind="queue" depth="8"/>)",
                  device_name(device), pair, device_name((device + 1) % cell.devices), pair) +
              "\n";
    }
  }
  return text + "</cell>\n";
}

/// Runs the nodes of a cell on this machine, and `takt` commands for this cell.
class Nodes {
 public:
  Nodes(const CellSettings& cell, int domain, const ScratchFolder& folder, Interruption& interruption)
      : cell_(cell), domain_(std::to_string(domain)), folder_(folder), interruption_(interruption) {}
  Nodes(const Nodes&) = delete;
  Nodes& operator=(const Nodes&) = delete;
  ~Nodes() { end(); }

  Result<void> start() {
    for (int device = 0; device < cell_.devices; ++device) {
      auto node = start_beside("takt-node",
                               {"--device", device_name(device), "--domain", domain_, "--quiet",
                                "--state-dir", folder_.file(device_name(device))},
                               false);
      if (!node) return node.problems();
      nodes_.push_back(std::move(*node));
    }
    return {};
  }

  /// Runs a `takt` command and returns how long it took. Its standard output is stored in `output`.
  Result<Nanoseconds> run(std::vector<std::string> command, std::string* output = nullptr) {
    command.emplace_back("--domain");
    command.push_back(domain_);
    const Instant begin = os::now();
    auto done = run_beside("takt", command, interruption_);
    if (!done) return done.problems();
    if (output != nullptr) *output = std::move(*done);
    return os::now() - begin;
  }

  Result<json> status() {
    std::string text;
    if (auto done = run({"status", "--json"}, &text); !done) return done.problems();
    return model::parse_json(text);
  }

  /// Waits until `takt status` finds all nodes.
  Result<void> wait_for_all() {
    const Instant limit = os::now() + kCellFound;
    while (true) {
      const auto seen = status();
      if (!seen) return seen.problems();
      int alive = 0;
      for (const json& device : (*seen)["devices"])
        alive +=
            device["name"].get<std::string>().rfind("bench", 0) == 0 && device["alive"].get<bool>() ? 1 : 0;
      if (alive >= cell_.devices) return {};
      if (os::now() > limit)
        return fail(fmt::format("only {} of {} nodes are on the network after 60 s", alive, cell_.devices));
    }
  }

  [[nodiscard]] std::set<int> process_ids() const {
    std::set<int> ids;
    for (const os::Child& node : nodes_) ids.insert(node.pid());
    return ids;
  }

  void end() {
    for (const os::Child& node : nodes_) node.signal(os::kTerminate);
    for (os::Child& node : nodes_) {
      if (node.running()) node.wait();
    }
    nodes_.clear();
  }

 private:
  const CellSettings& cell_;
  std::string domain_;
  const ScratchFolder& folder_;
  Interruption& interruption_;
  std::vector<os::Child> nodes_;
};

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

Row times_row(const char* name, const std::vector<std::int64_t>& times) {
  const Distribution d = distribution_of(times);
  Row row{name, in_columns(d)};
  row.values.push_back(static_cast<double>(d.count));
  return row;
}

}  // namespace

Result<std::vector<Section>> cell(const Settings& settings, Problems& refused) {
  const Nanoseconds period = settings.period.value_or(kCellPeriod);
  const Nanoseconds length = settings.length(kCellSeconds);
  const int domain = settings.domain.value_or(0);
  auto interruption = Interruption::create();
  if (!interruption) return interruption.problems();
  const auto folder = ScratchFolder::create();
  if (!folder) return folder.problems();
  const std::size_t samples = static_cast<std::size_t>(length / period) * 2 + 1000;
  const auto file = folder->write("cell.xml", descriptor_of(settings.cell, period, samples, *folder));
  if (!file) return file.problems();

  Section times{.title = fmt::format("{} devices with {} modules each, every {}, all on this machine",
                                     settings.cell.devices, 2 * settings.cell.pairs, takt::to_text(period)),
                .columns = {"s"}};
  Nodes nodes{settings.cell, domain, *folder, *interruption};
  Course course{settings, 5};
  course.next("start of the nodes");
  const Instant begin = os::now();
  if (auto started = nodes.start(); !started) return started.problems();
  if (auto all = nodes.wait_for_all(); !all) return all.problems();
  times.rows.push_back({"start of all nodes, until discovered", {seconds(os::now() - begin)}});
  course.next("takt deploy");
  const auto deployed = nodes.run({"deploy", *file});
  if (!deployed) return deployed.problems();
  times.rows.push_back({"takt deploy", {seconds(*deployed)}});

  course.next("run of the cell");
  for (const Instant end = os::now() + length; os::now() < end && !interruption->ended();)
    os::wait_readable({&interruption->fd()},
                      static_cast<int>(std::max<std::int64_t>(1, (end - os::now()) / 1ms)));

  const Instant asked = os::now();
  const auto status = nodes.status();
  if (!status) return status.problems();
  times.rows.push_back({"takt status", {seconds(os::now() - asked)}});
  std::uint64_t rows = 0;
  std::uint64_t missed = 0;
  std::set<int> processes = nodes.process_ids();
  for (const json& device : (*status)["devices"]) {
    if (!device["real_time"].get<bool>())
      add_once(refused, {fail("the nodes' threads have no real-time scheduling", "run takt bench as root")});
    for (const json& executor : device["executors"]) {
      rows += executor["cycles"].get<std::uint64_t>();
      missed += executor["missed"].get<std::uint64_t>();
    }
    for (const json& module : device["modules"]) processes.insert(module["pid"].get<int>());
  }
  std::uint64_t memory = 0;
  for (const int pid : processes) memory += os::memory_of(pid);
  course.next("takt undeploy");
  const auto undeployed = nodes.run({"undeploy", "bench"});
  if (!undeployed) return undeployed.problems();
  times.rows.push_back({"takt undeploy", {seconds(*undeployed)}});
  nodes.end();
  times.notes = {fmt::format(
      "{} rows ran and {} were missed; {:.0f} MB of memory in {} processes (proportional set size)", rows,
      missed, static_cast<double>(memory) / 1e6, processes.size())};

  std::vector<std::int64_t> ages;
  for (int device = 0; device < settings.cell.devices; ++device) {
    for (int pair = 0; pair < settings.cell.pairs; ++pair) {
      const auto some = values_of(Recording::read(folder->file(recording_name(device, pair))));
      ages.insert(ages.end(), some.begin(), some.end());
    }
  }
  course.next("DDS alone");
  const auto bare = run_bare_dds({.domain = domain, .period = period, .length = length});
  if (!bare) return bare.problems();
  Section way{.title = "a sample of 64 bytes, reliable, over the loopback interface",
              .columns = time_columns()};
  way.columns.emplace_back("samples");
  way.rows = {times_row("from module to module", ages), times_row("DDS alone", *bare)};
  way.notes = {
      "from module to module: from write() in the sender's run() to read() in the receiver's run(), which "
      "the",
      "sample releases. DDS alone: from write() in one process to the reader's listener in another process."};
  return std::vector<Section>{std::move(times), std::move(way)};
}

}  // namespace takt::bench
