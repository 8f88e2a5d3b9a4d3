// What modules did that no real-time code may, as libtakt_check wrote it down.
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

/// One of them, in words.
struct SeenViolation {
  std::uint32_t module = 0;          ///< its index; with channel::kOfExecutor that of the executor
  std::string hook;                  ///< "run()"; empty between modules
  std::string kind;                  ///< "allocation"
  std::string what;                  ///< "malloc", "clock_nanosleep"; of a page fault empty
  std::vector<std::string> calls{};  ///< innermost first; empty where it has no place
};

class Violations {
 public:
  /// Fails where libtakt_check.so is not where takt-host is. What is told of others than so many modules and
  /// executors is passed over: foreign code writes in that memory too.
  static Result<Violations> create(std::size_t modules, std::size_t executors);

  /// What a program that is checked is started with; its descriptor is added to `inherit`. It stays valid as
  /// long as this.
  std::vector<std::pair<std::string, std::string>> environment(std::vector<const os::Fd*>& inherit) const;

  /// Those that were seen for the first time since this was called last. `paths` are those of the modules'
  /// components.
  std::vector<SeenViolation> news(const std::vector<std::string>& paths);
  /// What this machine does not show; each is said once.
  std::vector<std::string> blind();
  /// How many there were of each module and executor, with their module numbers, ascending.
  [[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint64_t>> counts() const;
  /// The list `realtime_violations` of a device's report: {module, hook, kind, what, count, backtrace}, in
  /// the order in which they were seen first. Of an executor `module` is empty and `executor` is its name.
  [[nodiscard]] nlohmann::ordered_json report(const model::Device& device) const;

 private:
  struct Seen {
    SeenViolation words;
    std::size_t entry;  ///< in the log
  };

  [[nodiscard]] const channel::ViolationLog& log() const noexcept;
  SeenViolation in_words(const channel::Violation& violation, const std::vector<std::string>& paths);

  os::SharedMemory memory_;
  std::size_t modules_ = 0;
  std::size_t executors_ = 0;
  std::string library_;
  Symbols symbols_;
  std::vector<Seen> seen_;
  std::vector<bool> said_;  ///< of each entry
  std::uint32_t blind_said_ = 0;
  bool dropped_said_ = false;
};

/// "malloc, an allocation, in fill() at x.cpp:3 in x.so, called by ...": the innermost calls, without those
/// of the C and the C++ library.
std::string sentence_of(const SeenViolation& violation);

}  // namespace takt::node
