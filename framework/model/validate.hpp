// Everything a cell can be wrong about that needs no file of a component and no machine.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

/// Bounds that hold everywhere, so that memory is decided before anything runs.
inline constexpr std::size_t kMaxNameLength = 63;
inline constexpr std::size_t kMaxDevices = 1000;
inline constexpr std::size_t kMaxModules = 10000;  ///< of one device
inline constexpr std::size_t kMaxExecutors = 64;   ///< of one device
inline constexpr std::size_t kMaxFilename = 4096;  ///< bytes
inline constexpr std::size_t kMaxProblems = 1000;  ///< of one cell; further ones are not told
inline constexpr int kMaxDomain = 232;
inline constexpr int kMaxCpu = 1023;
inline constexpr int kMinExecutorPriority = 2;
inline constexpr int kMaxExecutorPriority = 98;
inline constexpr int kMaxAttempts = 1000;
inline constexpr Nanoseconds kMaxBackoff = std::chrono::hours{1};
inline constexpr int kMaxDepth = 65536;

/// A name of a cell, device, executor, module, port or property: a letter or '_', then letters, digits, '_'
/// and '-', at most kMaxNameLength bytes. No dot: `device.module.port` must have one reading.
bool is_valid_name(std::string_view name);

/// What a reader of a descriptor did not understand, so that nothing is said that only follows from that: a
/// module that could not be read is not a module that a connection names in vain.
struct Gaps {
  struct OfDevice {
    bool executors = false;  ///< there may be executors that the cell does not hold
    bool modules = false;
  };
  bool devices = false;
  std::vector<OfDevice> of_device;  ///< as Cell::devices; one that is missing has no gaps
  std::vector<bool> without_ends;   ///< as Cell::connections: true where `from` and `to` are not known
};

/// All problems of the cell at once, by line, each with `file:line` and a fix; empty when there are none.
/// Where there is neither file nor line, `where` is "cell NAME".
Problems validate(const Cell& cell);
Problems validate(const Cell& cell, const Gaps& gaps);

/// The name of a module that has no <name>: "build/controller1.so" is "controller1".
std::string file_stem(std::string_view filename);

}  // namespace takt::model
