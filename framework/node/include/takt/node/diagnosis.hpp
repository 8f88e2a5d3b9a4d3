// Judges what a machine's properties mean for real time: which of them spoil it, why, and the cure. It reads
// nothing itself: the caller passes the properties and the results of trials.
#pragma once

#include <string>
#include <vector>

#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>

namespace takt::node {

enum class Severity {
  good,
  note,    ///< costs some jitter, always or under the conditions that the text names
  spoils,  ///< control loops will miss their releases
};
const char* to_text(Severity severity) noexcept;

struct Finding {
  std::string name;  ///< of the check: "preemption"
  Severity severity = Severity::good;
  std::string found;
  std::string why;        ///< why it matters
  std::string cure{};     ///< a command, or what else to do; empty: nothing needs to be done
  std::string mend_on{};  ///< where the cure must be applied; empty: on this machine, in this container
};

/// One finding for each check, in a fixed order, the good ones too.
std::vector<Finding> diagnose(const os::Machine& machine, const os::Trial& trial);

}  // namespace takt::node
