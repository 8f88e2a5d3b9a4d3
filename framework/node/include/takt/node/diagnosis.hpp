// What a machine's properties mean for real time: which of them spoil it, why, and what mends them. Pure:
// what was read and tried is handed in.
#pragma once

#include <string>
#include <vector>

#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>

namespace takt::node {

enum class Severity {
  good,
  note,    ///< costs some jitter, or does under circumstances that are named
  spoils,  ///< control loops will miss their instants
};
const char* to_text(Severity severity) noexcept;

struct Finding {
  std::string name;  ///< of the check: "preemption"
  Severity severity = Severity::good;
  std::string found;
  std::string why;        ///< it matters
  std::string cure{};     ///< a command, or what else to do; empty where there is nothing to mend
  std::string mend_on{};  ///< where else than in here the cure works; empty: here
};

/// One finding for each check, in a fixed order, the good ones too.
std::vector<Finding> diagnose(const os::Machine& machine, const os::Trial& trial);

}  // namespace takt::node
