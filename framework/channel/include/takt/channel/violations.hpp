// The shared memory in which libtakt_check records real-time violations of modules. The thread that violates
// the rules, in the host or in a process module, writes the violation, and the node reads it. Initially all
// bytes are zero.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/core/fixed_text.hpp>

namespace takt::channel {

/// Environment variables of a checked process: the file descriptor of the ViolationLog and, for a process
/// module, the index of the module.
inline constexpr const char* kCheckFd = "TAKT_CHECK_FD";
inline constexpr const char* kCheckModule = "TAKT_CHECK_MODULE";

/// This bit marks the `module` of a violation as the index of an executor, whose thread was between two
/// modules. Without this bit, `module` is the index of a module.
inline constexpr std::uint32_t kOfExecutor = 1U << 31;

enum class ViolationKind : std::uint32_t { allocation, lock, system_call, page_fault };
/// Returns "allocation", "lock", "system call" or "page fault".
const char* to_text(ViolationKind kind) noexcept;

/// A code location in a loaded object (program or library). The address is relative to the load address of
/// the object, as in its symbol table; it is absolute if the object is unknown.
struct CodePlace {
  std::uint32_t object = 0;  ///< index of the object in the log, plus 1; 0: unknown
  std::uint64_t address = 0;
};

struct Violation {
  static constexpr std::size_t kFrames = 24;

  std::atomic<std::uint64_t> key;    ///< a hash of the violation's kind and place; 0: this entry is free. The
                                     ///< thread that changes 0 to a key owns the entry
  std::atomic<std::uint32_t> ready;  ///< 1 when all members below except `count` are complete
  std::uint32_t module;              ///< index of the module, or of an executor, see kOfExecutor
  Doing hook;
  ViolationKind kind;
  std::int64_t system_call;  ///< number of the system call
  FixedText<32> function;    ///< the C library function; empty for a system call or a page fault
  std::uint32_t depth;
  std::array<CodePlace, kFrames> frames;  ///< innermost first
  std::atomic<std::uint64_t> count;
};

struct LoadedObject {
  std::atomic<std::uint32_t> ready;  ///< 1 when `path` is complete
  FixedText<256> path;
};

struct ViolationLog {
  static constexpr std::size_t kViolations = 256;
  static constexpr std::size_t kObjects = 64;
  /// The bits of `blind`. Each bit stands for a kind of event that this machine cannot observe.
  static constexpr std::uint32_t kNoSystemCalls = 1;  ///< this kernel does not report system calls
  static constexpr std::uint32_t kNoFaultPlaces = 2;  ///< page faults are counted, but not located

  std::array<Violation, kViolations> violations;
  std::array<LoadedObject, kObjects> objects;
  std::atomic<std::uint32_t> claimed_objects;
  std::atomic<std::uint64_t> dropped;  ///< number of violations that were not recorded, because the log was
                                       ///< full
  std::atomic<std::uint32_t>
      blind;  ///< the events that this machine cannot observe; see kNoSystemCalls and kNoFaultPlaces
};

}  // namespace takt::channel
