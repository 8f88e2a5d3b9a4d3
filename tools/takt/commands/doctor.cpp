// takt doctor: lists everything on this machine that spoils real-time behaviour, and how to correct it.
#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/node/diagnosis.hpp>
#include <takt/node/node.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/process.hpp>
#include <takt/security/identity.hpp>

#include "commands/commands.hpp"
#include "reports/doctor_report.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::chrono::milliseconds kMoment{500};

struct DoctorOptions {
  bool json = false;
};

double microseconds(Nanoseconds time) { return static_cast<double>(time.count()) / 1e3; }

/// Checks the security of this machine. Security does not affect real time, but it is just as important,
/// because it decides who may command this machine.
node::Finding security_finding() {
  using node::Severity;
  node::Finding finding{
      .name = "security",
      .found = {},
      .why = "without security, anyone on the network of a cell may command it and read its data"};
  const std::string folder = client::security_of({});
  if (folder.empty()) {
    finding.severity = Severity::note;
    finding.found = "is off, because TAKT_SECURITY is not set";
    finding.cure =
        "run takt secure init CELL.xml DIR, or keep unknown machines off the network (docs/secure.md)";
    return finding;
  }
  std::error_code error;
  const std::int64_t now = os::wall_ns() / 1'000'000'000;
  if (std::filesystem::is_directory(folder + "/authority", error)) {
    finding.severity = Severity::note;
    finding.found = folder + " contains the authority: anyone who copies it can issue any identity";
    finding.cure =
        "keep the authority on another machine, and copy only the folder of this machine's device here";
    return finding;
  }
  const auto identity = security::read_identity(folder, now);
  if (!identity) {
    finding.severity = Severity::note;
    finding.found = "the identity in TAKT_SECURITY is rejected: " + in_words(identity.problems());
    finding.cure = "run takt secure renew, and copy the identity's folder to this machine again";
    return finding;
  }
  finding.found = "is on: " + to_text(identity->subject);
  if (const std::string warning = security::expiry_warning(identity->until, now); !warning.empty()) {
    finding.severity = Severity::note;
    finding.found += "; " + warning;
    finding.cure = "run takt secure renew, and copy the identity's folder to this machine again";
  }
  return finding;
}

Json report_of(const os::Machine& machine, const os::Trial& trial) {
  std::size_t spoils = 0;
  std::size_t notes = 0;
  Json findings = Json::array();
  std::vector<node::Finding> all = node::diagnose(machine, trial);
  all.push_back(security_finding());
  for (const node::Finding& finding : all) {
    spoils += finding.severity == node::Severity::spoils ? 1 : 0;
    notes += finding.severity == node::Severity::note ? 1 : 0;
    findings.push_back({{"check", finding.name},
                        {"severity", to_text(finding.severity)},
                        {"found", finding.found},
                        {"why", finding.why},
                        {"cure", finding.cure},
                        {"mend_on", finding.mend_on}});
  }
  return {{"machine", os::host_name()},
          {"kernel", machine.kernel},
          {"root", os::is_root()},
          {"spoils", spoils},
          {"notes", notes},
          {"findings", findings},
          {"wake_up_us",
           {{"count", trial.wake_ups.count},
            {"p50", microseconds(trial.wake_ups.p50)},
            {"p99", microseconds(trial.wake_ups.p99)},
            {"max", microseconds(trial.wake_ups.max)}}}};
}

/// Starts takt-node to try its rights, because its file may have capabilities that the file of takt does not
/// have.
void try_node(os::Trial& trial) {
  auto child = os::Child::spawn({.program = os::program_directory() + "/takt-node",
                                 .environment = {{node::kTryRights, "1"}},
                                 .capture_output = true});
  if (!child) {
    trial.node_error = in_words(child.problems());
    return;
  }
  const os::ProcessEnd end = child->wait();
  trial.node_is_real_time = !end.signalled && end.code == 0;
  if (end.signalled || end.code > 1) {
    bool over = false;
    const std::string text = os::read_available(child->error, &over);
    trial.node_error = text.empty() ? end.text() : on_one_line(text.substr(0, text.find('\n')));
  }
}

int doctor(const DoctorOptions& options) {
  const os::Machine machine = os::read_machine();
  os::Trial trial = os::try_machine(kMoment);
  try_node(trial);
  const Json report = report_of(machine, trial);
  if (!print(options.json ? model::json_text(report) + "\n" : doctor_text(report, terminal_style()))) {
    return 1;
  }
  return report["spoils"].get<std::size_t>() == 0 ? 0 : 1;
}

}  // namespace

void add_doctor(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<DoctorOptions>();
  auto* command = app.add_subcommand(
      "doctor", "List everything on this machine that spoils real-time behaviour, and how to correct it");
  command->add_flag("--json", options->json, "print one JSON object");
  command->footer(
      "The command changes nothing and takes a second. Without root, it reports which checks need root.\n"
      "Exit status: 0 nothing spoils real-time behaviour (there may be notes), 1 something does, 2 wrong "
      "usage.");
  command->callback([options, &chosen] { chosen = [options] { return doctor(*options); }; });
}

}  // namespace takt::tool
