// The memory in which libtakt_check writes down what a module does that no real-time code may: written by the
// thread that does it, in the host or in a program, and read by their node. All zero is its initial state.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/core/fixed_text.hpp>

namespace takt::channel {

/// The environment of a program that is checked: the descriptor of the memory, and which module it is.
inline constexpr const char* kCheckFd = "TAKT_CHECK_FD";
inline constexpr const char* kCheckModule = "TAKT_CHECK_MODULE";

/// Which module something belongs to: its index, or, with this bit, the index of the executor that was
/// between two modules.
inline constexpr std::uint32_t kOfExecutor = 1U << 31;

enum class ViolationKind : std::uint32_t { allocation, lock, system_call, page_fault };
/// "allocation", "lock", "system call", "page fault".
const char* to_text(ViolationKind kind) noexcept;

/// A place in a loaded object, as the object's own file counts addresses.
struct CodePlace {
  std::uint32_t object = 0;  ///< its index + 1 in the log; 0: unknown
  std::uint64_t address = 0;
};

struct Violation {
  static constexpr std::size_t kFrames = 24;

  std::atomic<std::uint64_t> key;    ///< of what is the same; 0: free. SYNC: violation claimed
  std::atomic<std::uint32_t> ready;  ///< SYNC: violation, publishes everything below but `count`
  std::uint32_t module;              ///< as kOfExecutor says
  Doing hook;
  ViolationKind kind;
  std::int64_t system_call;  ///< its number
  FixedText<32> function;    ///< of the C library; empty for a system call and a page fault
  std::uint32_t depth;
  std::array<CodePlace, kFrames> frames;  ///< innermost first
  std::atomic<std::uint64_t> count;
};

struct LoadedObject {
  std::atomic<std::uint32_t> ready;  ///< SYNC: object, publishes path
  FixedText<256> path;
};

struct ViolationLog {
  static constexpr std::size_t kViolations = 256;
  static constexpr std::size_t kObjects = 64;
  /// Bits of `blind`.
  static constexpr std::uint32_t kNoSystemCalls = 1;  ///< this kernel does not show them
  static constexpr std::uint32_t kNoFaultPlaces = 2;  ///< page faults are counted and not placed

  std::array<Violation, kViolations> violations;
  std::array<LoadedObject, kObjects> objects;
  std::atomic<std::uint32_t> claimed_objects;
  std::atomic<std::uint64_t> dropped;  ///< that found no room
  std::atomic<std::uint32_t> blind;
};

}  // namespace takt::channel
