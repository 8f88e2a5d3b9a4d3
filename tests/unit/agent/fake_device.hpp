// An agent that runs with fakes instead of DDS, processes and clocks. Tests read the messages that the agent
// publishes, and control its deployment.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/agent/agent.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/node/fault_record.hpp>
#include <takt/node/kept_deployment.hpp>
#include <takt/wire/words.hpp>

namespace takt::agent {

class RecordingPublisher final : public Publisher {
 public:
  void reply(const wire::WholeReply& reply) override { replies.push_back(reply); }
  void publish(const LifecycleStatus& status) override { steps.push_back(status); }
  void publish(const DeviceStatus& status) override { devices.push_back(status); }
  void publish(const Measures&) override { ++measures; }
  void publish(const FaultEvent& event) override { faults.push_back(event); }
  void withdraw(const std::vector<LifecycleStatus>& modules, const Measures&) override {
    for (const LifecycleStatus& module : modules) withdrawn.push_back(module.path().to_string());
  }

  std::vector<wire::WholeReply> replies;
  std::vector<LifecycleStatus> steps;
  std::vector<DeviceStatus> devices;
  std::vector<FaultEvent> faults;
  std::vector<std::string> withdrawn;
  int measures = 0;
};

/// The calls that the fakes received, and the results that they return.
struct Work {
  std::vector<InspectionRequest> inspections;
  /// The result that FakeInspection returns. Empty while the inspection is in progress.
  std::optional<Result<Inspected>> inspected;
  Result<void> prepared{};
  Supervised::Phase phase = Supervised::Phase::preparing;
  Problems failures;
  std::optional<Instant> t0;
  bool stops_cell = false;
  std::vector<model::SafeOutput> safe;
  bool stop_called = false;
  int supervised = 0;  ///< number of FakeSupervised objects that exist
  model::Cell cell;    ///< the cell of the FakeSupervised that was created last
  std::vector<std::string> paths;
  std::function<void(const Step&)> stepped;
  std::function<void(model::Fault, const std::string&)> noted;
  std::function<bool(const std::string& device)> is_lost;
  std::vector<std::pair<std::uint32_t, Verb>> commands;
  /// Requests for properties of modules: "0 gain" reads `gain` of module 0, and "0 gain = 2" sets it to 2.
  std::vector<std::string> properties;
  std::vector<std::pair<std::uint32_t, supervision::ForceRequest>> forces;
  std::vector<std::string> ended_forces;
  Nanoseconds tapped_every{0};
  Result<void> may_swap{};
  std::vector<std::pair<std::uint32_t, std::string>> swaps;
  std::vector<std::function<void(const Outcome&)>> done;
  Standing standing;
  std::string unmatched;
};

class FakeInspection final : public Inspection {
 public:
  explicit FakeInspection(Work& work) : work_(work) {}
  std::optional<Result<Inspected>> result() override { return work_.inspected; }

 private:
  Work& work_;
};

class FakeSupervised final : public Supervised {
 public:
  FakeSupervised(Work& work, const Supervisor::Options& options) : work_(work) {
    ++work_.supervised;
    work_.phase = Phase::preparing;
    work_.cell = options.cell;
    work_.paths = options.paths;
    work_.stepped = options.stepped;
    work_.noted = options.noted;
    work_.is_lost = options.is_lost;
  }
  ~FakeSupervised() override { --work_.supervised; }

  Result<void> prepare() override { return work_.prepared; }
  void go(Instant t0) override {
    work_.t0 = t0;
    work_.phase = Phase::running;
  }
  void stop() override {
    work_.stop_called = true;
    work_.phase = Phase::stopping;
  }
  void stop_for(Problem problem) override {
    work_.failures.push_back(std::move(problem));
    work_.stops_cell = true;
    stop();
  }
  void give_safe(const std::vector<model::SafeOutput>& outputs) override { work_.safe = outputs; }
  void step() override {}
  void command(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) override {
    work_.commands.emplace_back(module, verb);
    work_.done.push_back(std::move(done));
  }
  Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant, Nanoseconds every) override {
    work_.tapped_every = every;
    return Tapped{"takt/cell/robot/" + std::to_string(module) + "/" + port, "t", false};
  }
  Result<std::string> force(std::uint32_t module, const supervision::ForceRequest& request) override {
    work_.forces.emplace_back(module, request);
    return request.data;
  }
  Result<void> end_force(std::uint32_t module, const std::string& port, const std::string& who) override {
    work_.ended_forces.push_back(std::to_string(module) + " " + port + " by " + who);
    return {};
  }
  void get(std::uint32_t module, const std::string& property,
           std::function<void(const Outcome&)> done) override {
    work_.properties.push_back(std::to_string(module) + " " + property);
    work_.done.push_back(std::move(done));
  }
  void set(std::uint32_t module, const std::string& property, const std::string& value,
           std::function<void(const Outcome&)> done) override {
    work_.properties.push_back(std::to_string(module) + " " + property + " = " + value);
    work_.done.push_back(std::move(done));
  }
  [[nodiscard]] Result<void> may_swap(std::uint32_t) const override { return work_.may_swap; }
  void swap(std::uint32_t module, const std::string& path, const std::map<std::string, std::string>& values,
            std::function<void(const Outcome&)> done) override {
    std::string text = path;
    for (const auto& [name, value] : values) text += " " + name + " = " + value;
    work_.swaps.emplace_back(module, text);
    work_.done.push_back(std::move(done));
  }
  void trace(Nanoseconds last, std::size_t most,
             std::function<void(const Result<std::string>&)> done) override {
    done(std::to_string(last.count()) + " of " + std::to_string(most));
  }
  [[nodiscard]] std::string unmatched() const override { return work_.unmatched; }
  [[nodiscard]] Phase phase() const noexcept override { return work_.phase; }
  [[nodiscard]] const Problems& failures() const noexcept override { return work_.failures; }
  [[nodiscard]] bool stops_cell() const noexcept override { return work_.stops_cell; }
  [[nodiscard]] Standing standing() const override { return work_.standing; }
  [[nodiscard]] nlohmann::ordered_json report() const override { return {{"name", "robot"}}; }
  [[nodiscard]] Measures measures() const override { return {}; }

 private:
  Work& work_;
};

/// The agent of one device, by default `robot`, with functions to send commands to the agent and to advance
/// the agent's time.
class FakeDevice {
 public:
  static constexpr const char* kCell = R"(<cell name="cell">
  <device name="robot">
    <module><name>servo</name><filename>servo.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>1000000</period><priority>1</priority></module>
    <module><name>arm</name><filename>arm.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>1000000</period><priority>2</priority></module>
  </device>
  <device name="line">
    <module><name>belt</name><filename>belt.so</filename><moduletype>thread</moduletype>
      <operationtype>periodic</operationtype><period>1000000</period><priority>1</priority></module>
  </device>
</cell>)";

  explicit FakeDevice(std::shared_ptr<DeploymentStore> store = {}, bool temporary = false,
                      std::shared_ptr<node::FaultRecord> record = {},
                      const std::string& cell_of_identity = {}, const std::string& name = "robot",
                      const std::string& node = "")
      : agent({.device = name,
               .node = !node.empty()     ? node
                       : name == "robot" ? "here"
                                         : "node of " + name,
               .domain = 7,
               .cell = cell_of_identity,
               .temporary = temporary,
               .store = std::move(store),
               .boot = "since today",
               .record = record ? record : std::make_shared<node::FaultRecord>(),
               .log = [this](const std::string& text) { logged.push_back(text); },
               .now = [this] { return now; },
               .wall_ns = [this] { return wall(); },
               .instant_of_wall = [this](std::int64_t ns) { return now + Nanoseconds{ns - wall()}; }},
              {.parse = descriptor::parse,
               .inspect = [this](const InspectionRequest& request) -> Result<std::unique_ptr<Inspection>> {
                 work.inspections.push_back(request);
                 return std::unique_ptr<Inspection>{std::make_unique<FakeInspection>(work)};
               },
               .supervise = [this](Supervisor::Options options) -> std::unique_ptr<Supervised> {
                 return std::make_unique<FakeSupervised>(work, options);
               }},
              published) {
    agent.step();
  }

  [[nodiscard]] std::int64_t wall() const { return to_ns(now) + 1'700'000'000'000'000'000 + set.count(); }
  void pass(Nanoseconds time) {
    now += time;
    agent.step();
  }

  wire::WholeCommand command(CommandKind kind) {
    wire::WholeCommand c;
    c.head.id("c" + std::to_string(++asked));
    c.head.device("robot");
    c.head.kind(kind);
    c.head.deadline_ns(wall() + 1'000'000'000);
    return c;
  }
  /// Restores the saved deployment. The agent has looked for another node of its name.
  void resume() {
    agent.resume();
    pass(std::chrono::milliseconds{301});
  }
  void receive(const wire::WholeCommand& c) {
    agent.receive(c);
    agent.step();
  }
  /// Sends the descriptor of a new deployment.
  void prepare(const std::string& deployment = "d1", const std::string& text = kCell) {
    wire::WholeCommand c = command(COMMAND_PREPARE);
    c.head.deployment(deployment);
    c.head.property(deployment);
    c.head.value("cell.xml");
    c.data = text;
    receive(c);
  }
  /// Sends the command to start the modules of the new deployment, with the safe values of the cell's outputs
  /// as JSON.
  void change(const std::string& safe = "[]") {
    wire::WholeCommand c = command(COMMAND_CHANGE);
    c.head.deployment(id);
    c.head.property(id);
    c.data = R"({"devices": ["robot", "line"], "safe": )" + safe + "}";
    receive(c);
  }
  /// Sends T0, which is so far ahead of the present time.
  void run(Nanoseconds ahead = std::chrono::milliseconds{500}, const std::string& deployment = "") {
    wire::WholeCommand c = command(COMMAND_RUN);
    c.head.deployment(deployment.empty() ? id : deployment);
    c.head.property(deployment.empty() ? id : deployment);
    t0_wall = wall() + ahead.count();
    c.head.time_ns(t0_wall);
    receive(c);
  }
  /// The status that the other device of the cell publishes after it has received the same T0.
  [[nodiscard]] DeviceStatus of_line(DeviceState state) const {
    DeviceStatus line;
    wire::set(line.path(), "cell/line");
    wire::set(line.cell(), "cell");
    wire::set(line.device(), "line");
    wire::set(line.node(), "node of line");
    wire::set(line.deployment(), id);
    if (state >= DEVICE_ARMED) line.t0_ns(t0_wall);
    line.state(state);
    if (state != DEVICE_WAITING) wire::set(line.transaction(), id);
    line.stage(state < DEVICE_ARMED      ? STAGE_PREPARED
               : state == DEVICE_ARMED   ? STAGE_ARMED
               : state == DEVICE_STARTED ? STAGE_RUNNING
                                         : STAGE_FINAL);
    // This status answers a status that our device sent 100 us ago and that arrived at once.
    line.time_ns(wall() + line_ahead.count());
    StatusEcho& echo = line.echoes().emplace_back();
    wire::set(echo.node(), "here");
    echo.monotonic_ns(to_ns(now) - 100'000);
    return line;
  }
  static constexpr wire::WriterId kLine = 77;
  void hear_line(DeviceState state) {
    agent.receive(of_line(state), kLine, now);
    agent.step();
  }
  /// Lets the start of the cell succeed: the other device reports that it is armed, and then that it runs.
  /// Then withdraws the status of the other device.
  void start_with_line() {
    hear_line(DEVICE_ARMED);
    pass(Nanoseconds{t0_wall - wall()} - transaction::kBegins);
    pass(transaction::kBegins);
    hear_line(DEVICE_RUNNING);
    agent.others().remove(of_line(DEVICE_RUNNING), kLine);
  }
  void undeploy(const std::string& deployment = "") {
    wire::WholeCommand c = command(COMMAND_UNDEPLOY);
    c.head.deployment(deployment);
    receive(c);
  }
  /// Prepares a deployment and inspects its components. Then the agent begins to start the modules.
  void begin(const std::string& text = kCell, const Inspected& found = {.paths = {"/servo.so", "/arm.so"}},
             const std::string& safe = "[]") {
    prepare(id, text);
    work.inspected = found;
    agent.step();
    change(safe);
  }
  /// Prepares a deployment and lets it continue until the device can receive T0.
  void become_ready(const std::string& text = kCell,
                    const Inspected& found = {.paths = {"/servo.so", "/arm.so"}},
                    const std::string& safe = "[]") {
    begin(text, found, safe);
    become_prepared();
  }
  /// Lets every module reach START and lets the agent find the node of the other device. Then withdraws the
  /// status of the other device.
  void become_prepared() {
    work.phase = Supervised::Phase::ready;
    hear_line(DEVICE_READY);
    agent.others().remove(of_line(DEVICE_READY), kLine);
  }
  void become_running(const std::string& text = kCell,
                      const Inspected& found = {.paths = {"/servo.so", "/arm.so"}}) {
    become_ready(text, found);
    run();
    start_with_line();
    published.replies.clear();
  }
  void end() {
    work.phase = Supervised::Phase::ended;
    agent.step();
  }

  [[nodiscard]] const DeviceStatus& status() const { return published.devices.back(); }
  [[nodiscard]] const Reply& reply() const { return published.replies.back().head; }
  [[nodiscard]] std::string text() const { return reply().text().to_string(); }
  [[nodiscard]] nlohmann::ordered_json data() const {
    return nlohmann::ordered_json::parse(published.replies.back().data);
  }

  Instant now = from_ns(5'000'000'000);
  Nanoseconds line_ahead{0};  ///< wall clock of the other device minus the wall clock of this device
  Nanoseconds set{0};         ///< by how much a test has set the wall clock forward
  std::string id = "d1";      ///< id of the deployment; an agent accepts each id only once
  std::int64_t t0_wall = 0;
  int asked = 0;
  Work work;
  std::vector<std::string> logged;  ///< the lines that the agent has logged
  RecordingPublisher published;
  Agent agent;
};

}  // namespace takt::agent
