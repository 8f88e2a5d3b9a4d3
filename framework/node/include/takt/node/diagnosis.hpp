// Judges whether a machine is fit for real time: which properties of the machine spoil real-time behaviour,
// why, and what to do about them. These functions read nothing from the machine. The caller passes the
// machine's properties and the results of trials.
#pragma once

#include <string>
#include <vector>

#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>

namespace takt::node {

enum class Severity {
  good,
  note,    ///< adds some jitter, always or under the conditions that the text names
  spoils,  ///< control loops will miss their releases
};
const char* to_text(Severity severity) noexcept;

struct Finding {
  std::string name;  ///< name of the check, such as "preemption"
  Severity severity = Severity::good;
  std::string found;
  std::string why;        ///< why this property of the machine matters
  std::string cure{};     ///< what to do, for example a command; empty if nothing needs to be done
  std::string mend_on{};  ///< where to apply the cure; empty for this machine or container
};

/// Returns one finding for each check, in a fixed order. Good results are included.
std::vector<Finding> diagnose(const os::Machine& machine, const os::Trial& trial);

}  // namespace takt::node
