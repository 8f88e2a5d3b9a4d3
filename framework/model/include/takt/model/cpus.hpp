// The CPUs of a machine, as a process may use them.
#pragma once

#include <string>
#include <vector>

namespace takt::model {

/// Each list is in ascending order.
struct Cpus {
  std::vector<int> online{};  ///< the CPUs that the kernel uses
  /// The CPUs that an executor may request: the online CPUs, except those that a cpuset limit (of a cgroup, a
  /// service or a container) excludes. Isolated CPUs (isolcpus) are included.
  std::vector<int> permitted{};
  /// The CPUs of the threads that request none: the permitted CPUs without the isolated CPUs, and without
  /// those that taskset or CPUAffinity= excludes.
  std::vector<int> ordinary{};

  /// The CPUs of a machine that reserves none of them.
  static Cpus all(const std::vector<int>& cpus) { return {cpus, cpus, cpus}; }

  bool operator==(const Cpus&) const = default;
};

/// Converts numbers of CPUs to a list in the kernel's form, for example "0-2,5".
std::string cpus_text(const std::vector<int>& cpus);
/// Returns the CPUs in words, for example "CPU 3" or "CPUs 0-2,5".
std::string cpus_in_words(const std::vector<int>& cpus);

}  // namespace takt::model
