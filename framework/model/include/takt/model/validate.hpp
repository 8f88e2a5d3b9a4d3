// The rules for a cell that can be checked without its components and without a real machine.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

/// The limits of every cell. Because of these limits, the memory that a cell needs is known before it runs.
inline constexpr std::size_t kMaxNameLength = 63;
inline constexpr std::size_t kMaxDevices = 1000;
inline constexpr std::size_t kMaxModules = 10000;   ///< per device
inline constexpr std::size_t kMaxExecutors = 64;    ///< per device
inline constexpr std::size_t kMaxArguments = 1000;  ///< of one module
inline constexpr std::size_t kMaxArgument = 4096;   ///< of one argument, in bytes
inline constexpr std::size_t kMaxFilename = 4096;   ///< in bytes
inline constexpr std::size_t kMaxProblems = 1000;   ///< per cell; validate() does not report further problems
inline constexpr int kMaxDomain = 232;
inline constexpr int kMaxCpu = 1023;
inline constexpr int kMinExecutorPriority = 2;
inline constexpr int kMaxExecutorPriority = 98;
inline constexpr int kMaxAttempts = 1000;
inline constexpr int kMaxTolerance = 1000;  ///< maximum of `times` and `in-a-row` of a budget
inline constexpr int kMaxCatchUp = 1000;    ///< maximum number of missed releases that an overrun contract
                                            ///< makes up
inline constexpr int kMaxSpinPercent = 90;  ///< maximum of `spin`, in percent of the basic period
/// The shortest period of a module, and the shortest useful basic period: with a shorter one, no row could
/// end before the next row is due.
inline constexpr Nanoseconds kMinPeriod = std::chrono::microseconds{1};
inline constexpr Nanoseconds kMaxBackoff = std::chrono::hours{1};
inline constexpr int kMaxDepth = 65536;
inline constexpr std::size_t kMaxConnections = 100000;  ///< per cell
/// Leaves room for "/request", so that the name of a request port is not too long.
inline constexpr std::size_t kMaxServiceName = kMaxNameLength - 8;
inline constexpr std::size_t kMaxTopic = 255;  ///< in bytes; Fast DDS truncates longer names
inline constexpr std::size_t kMaxPeers = 256;
inline constexpr std::size_t kMaxHost = 253;  ///< maximum length of a host name, in bytes

class Findings;

/// Returns true if `name` is valid for a cell, device, executor, module, port or property: a letter or '_',
/// then letters, digits, '_' and '-', at most kMaxNameLength bytes. A dot is not allowed, because it
/// separates the parts of `device.module.port`.
bool is_valid_name(std::string_view name);

/// Returns true if `topic` is a valid topic name: 1 to kMaxTopic printable ASCII characters and no spaces.
bool is_valid_topic(std::string_view topic);

/// Returns true if `host` is an IPv4 address or a valid host name, without a port.
bool is_valid_host(std::string_view host);

/// Returns true if `server` has the form HOST:PORT with a port from 1 to 65535.
bool is_valid_server(std::string_view server);

/// The parts of a descriptor that its reader could not read. validate() suppresses problems that only follow
/// from these gaps. For example, if a module could not be read, a connection to an unknown module may name
/// that module and be correct.
struct Gaps {
  struct OfDevice {
    bool executors = false;  ///< true: the device may have executors that were not read
    bool modules = false;    ///< true: the device may have modules that were not read
  };
  bool devices = false;             ///< true: the descriptor may have devices that were not read
  bool discovery = false;           ///< true: some discovery attributes were not read
  std::vector<OfDevice> of_device;  ///< indexed like Cell::devices; a missing entry means no gaps
  std::vector<bool> without_ends;   ///< indexed like Cell::connections: true if `from` and `to` were not read
  /// Indexed like Cell::services: true if the client and the server were not read.
  std::vector<bool> without_sides{};
};

/// Returns all problems of the cell, sorted by line, each with `file:line` and a fix; empty if the cell is
/// valid. If file and line are not known, `where` of the problem is "cell NAME".
Problems validate(const Cell& cell);
Problems validate(const Cell& cell, const Gaps& gaps);
/// Adds the problems of the cell to `findings`, except problems that only follow from `gaps`.
void validate(const Cell& cell, const Gaps& gaps, Findings& findings);

/// Returns the default name of a module without <name>: "controller1" for the file "build/controller1.so".
std::string file_stem(std::string_view filename);

}  // namespace takt::model
