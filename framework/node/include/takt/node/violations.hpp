// Reads the real-time violations of modules, which libtakt_check has recorded in shared memory.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/channel/violations.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/node/symbols.hpp>
#include <takt/os/fd.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::node {

/// One real-time violation, as text.
struct SeenViolation {
  std::uint32_t module = 0;  ///< index of the module, or of the executor if channel::kOfExecutor is set
  std::string hook;          ///< the function of the module that was running, such as "run()"; empty between
                             ///< modules
  std::string kind;          ///< such as "allocation"
  std::string what;          ///< the called function, such as "malloc"; empty for a page fault
  /// The calls that led to the violation, innermost first; empty if they are not known.
  std::vector<std::string> calls{};
};

class Violations {
 public:
  /// Creates the memory in which libtakt_check records violations. Fails if libtakt_check.so is not in the
  /// folder of takt-host. Entries whose module or executor number is not below `modules` or `executors` are
  /// ignored, because foreign code can write to this memory.
  static Result<Violations> create(std::size_t modules, std::size_t executors);

  /// Returns the environment variables that switch on the check of a child process, and adds the file
  /// descriptor of the memory to `inherit`. The descriptor is valid as long as this object exists.
  std::vector<std::pair<std::string, std::string>> environment(std::vector<const os::Fd*>& inherit) const;

  /// Returns the violations that were first recorded since the last call. `paths` are the paths of the
  /// modules' components.
  std::vector<SeenViolation> news(const std::vector<std::string>& paths);
  /// Returns sentences about violations that cannot be detected on this machine, each sentence once.
  std::vector<std::string> limitations();
  /// Returns the number of violations of each module and executor, in the order of SeenViolation::module.
  [[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint64_t>> counts() const;
  /// Returns the list `realtime_violations` of a device's report: objects {module, hook, kind, what, count,
  /// backtrace} in the order of their first occurrence. For an executor, `module` is empty and `executor` is
  /// its name.
  [[nodiscard]] nlohmann::ordered_json report(const model::Device& device) const;

 private:
  struct Seen {
    SeenViolation words;
    std::size_t entry;  ///< index of the violation's entry in the violation log
  };

  [[nodiscard]] const channel::ViolationLog& log() const noexcept;
  SeenViolation in_words(const channel::Violation& violation, const std::vector<std::string>& paths);

  os::SharedMemory memory_;
  std::size_t modules_ = 0;
  std::size_t executors_ = 0;
  std::string library_;
  Symbols symbols_;
  std::vector<Seen> seen_;
  std::vector<bool> reported_;  ///< for each entry of the violation log, true if news() has read it
  std::uint32_t blind_reported_ = 0;
  bool dropped_reported_ = false;
};

/// Describes a violation, such as "malloc, an allocation, in fill() at x.cpp:3 in x.so, called by ...". Names
/// the innermost calls outside the C and C++ libraries.
std::string sentence_of(const SeenViolation& violation);

}  // namespace takt::node
