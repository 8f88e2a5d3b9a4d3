// Reads the real-time violations of modules that libtakt_check recorded.
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

/// One violation, described in text.
struct SeenViolation {
  std::uint32_t module = 0;  ///< index of the module, or of the executor if channel::kOfExecutor is set
  std::string hook;          ///< such as "run()"; empty between modules
  std::string kind;          ///< such as "allocation"
  std::string what;          ///< the called function, such as "malloc"; empty for a page fault
  std::vector<std::string> calls{};  ///< the calls, innermost first; empty if the place is not known
};

class Violations {
 public:
  /// Fails if libtakt_check.so is not in the folder of takt-host. Ignores entries whose module or executor
  /// number is not below `modules` or `executors`, because foreign code can write to the memory of the
  /// entries.
  static Result<Violations> create(std::size_t modules, std::size_t executors);

  /// Returns the environment variables for a checked program, and adds the descriptor of the memory to
  /// `inherit`. The descriptor is valid as long as this object exists.
  std::vector<std::pair<std::string, std::string>> environment(std::vector<const os::Fd*>& inherit) const;

  /// Returns the violations that occurred for the first time since the last call. `paths` are the paths of
  /// the modules' components.
  std::vector<SeenViolation> news(const std::vector<std::string>& paths);
  /// Returns sentences about what cannot be detected on this machine, each sentence once.
  std::vector<std::string> limitations();
  /// The number of violations of each module and executor, by ascending module number.
  [[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint64_t>> counts() const;
  /// The list `realtime_violations` of a device's report, with objects {module, hook, kind, what, count,
  /// backtrace} in the order of their first occurrence. For an executor, `module` is empty and `executor` is
  /// its name.
  [[nodiscard]] nlohmann::ordered_json report(const model::Device& device) const;

 private:
  struct Seen {
    SeenViolation words;
    std::size_t entry;  ///< its index in the violation log
  };

  [[nodiscard]] const channel::ViolationLog& log() const noexcept;
  SeenViolation in_words(const channel::Violation& violation, const std::vector<std::string>& paths);

  os::SharedMemory memory_;
  std::size_t modules_ = 0;
  std::size_t executors_ = 0;
  std::string library_;
  Symbols symbols_;
  std::vector<Seen> seen_;
  std::vector<bool> reported_;  ///< for each entry of the log, whether news() returned it
  std::uint32_t blind_reported_ = 0;
  bool dropped_reported_ = false;
};

/// Describes a violation, such as "malloc, an allocation, in fill() at x.cpp:3 in x.so, called by ...". Names
/// the innermost calls, without those in the C and C++ libraries.
std::string sentence_of(const SeenViolation& violation);

}  // namespace takt::node
