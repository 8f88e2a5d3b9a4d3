// takt doctor: what on this machine would spoil real time, each with its cure.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>
#include <takt/node/diagnosis.hpp>
#include <takt/os/environment.hpp>

#include "commands.hpp"
#include "doctor_report.hpp"
#include "terminal.hpp"

namespace takt::tool {

namespace {

using json = nlohmann::ordered_json;

constexpr std::chrono::milliseconds kMoment{500};

struct DoctorOptions {
  bool json = false;
};

double microseconds(Nanoseconds time) { return static_cast<double>(time.count()) / 1e3; }

json report_of(const os::Machine& machine, const os::Trial& trial) {
  std::size_t spoils = 0;
  std::size_t notes = 0;
  json findings = json::array();
  for (const node::Finding& finding : node::diagnose(machine, trial)) {
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

int doctor(const DoctorOptions& options) {
  const os::Machine machine = os::read_machine();
  const json report = report_of(machine, os::try_machine(kMoment));
  if (!print(options.json ? model::json_text(report) + "\n" : doctor_text(report, terminal_style()))) {
    return 1;
  }
  return report["spoils"].get<std::size_t>() == 0 ? 0 : 1;
}

}  // namespace

void add_doctor(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<DoctorOptions>();
  auto* command =
      app.add_subcommand("doctor", "Say what on this machine would spoil real time, each with its cure");
  command->add_flag("--json", options->json, "print one JSON object");
  command->footer(
      "Changes nothing; takes a second. Works without root and says what it could not see then.\n"
      "Exit status: 0 nothing spoils real time (there may be notes), 1 something does, 2 wrong usage.");
  command->callback([options, &chosen] { chosen = [options] { return doctor(*options); }; });
}

}  // namespace takt::tool
