// The rules of a cell that can be checked without its components and without a machine.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

/// The limits of every cell, so that the memory that a cell needs is known before anything runs.
inline constexpr std::size_t kMaxNameLength = 63;
inline constexpr std::size_t kMaxDevices = 1000;
inline constexpr std::size_t kMaxModules = 10000;  ///< of one device
inline constexpr std::size_t kMaxExecutors = 64;   ///< of one device
inline constexpr std::size_t kMaxFilename = 4096;  ///< bytes
inline constexpr std::size_t kMaxProblems = 1000;  ///< of one cell; further ones are not reported
inline constexpr int kMaxDomain = 232;
inline constexpr int kMaxCpu = 1023;
inline constexpr int kMinExecutorPriority = 2;
inline constexpr int kMaxExecutorPriority = 98;
inline constexpr int kMaxAttempts = 1000;
inline constexpr int kMaxTolerance = 1000;  ///< of a budget: times, and in a row
inline constexpr int kMaxCatchUp = 1000;    ///< releases that catch-up makes up
inline constexpr int kMaxSpinPercent = 90;  ///< of the basic period
inline constexpr Nanoseconds kMaxBackoff = std::chrono::hours{1};
inline constexpr int kMaxDepth = 65536;
inline constexpr std::size_t kMaxConnections = 100000;              ///< of one cell
inline constexpr std::size_t kMaxServiceName = kMaxNameLength - 8;  ///< with /request it is a port name
inline constexpr std::size_t kMaxTopic = 255;  ///< bytes; Fast DDS truncates longer names
inline constexpr std::size_t kMaxPeers = 256;
inline constexpr std::size_t kMaxHost = 253;  ///< bytes

class Findings;

/// Whether this is a valid name of a cell, device, executor, module, port or property: a letter or '_', then
/// letters, digits, '_' and '-', at most kMaxNameLength bytes. A dot is not allowed, because it separates the
/// parts of `device.module.port`.
bool is_valid_name(std::string_view name);

/// Whether this is a valid topic of a connection: 1 to kMaxTopic printable ASCII characters, no space.
bool is_valid_topic(std::string_view topic);

/// Whether this is an IPv4 address or a host name, without a port.
bool is_valid_host(std::string_view host);

/// Whether this is HOST:PORT with a port from 1 to 65535.
bool is_valid_server(std::string_view server);

/// The parts of a descriptor that its reader could not read. validate() uses them to suppress problems that
/// only follow from these gaps: if a module could not be read, a connection to an unknown module may be
/// correct.
struct Gaps {
  struct OfDevice {
    bool executors = false;  ///< the device may have executors that are not in the cell
    bool modules = false;    ///< the device may have modules that are not in the cell
  };
  bool devices = false;               ///< the descriptor may have devices that are not in the cell
  bool discovery = false;             ///< the attributes of discovery are not all known
  std::vector<OfDevice> of_device;    ///< indexed as Cell::devices; a missing entry means no gaps
  std::vector<bool> without_ends;     ///< indexed as Cell::connections: true if `from` and `to` are not known
  std::vector<bool> without_sides{};  ///< indexed as Cell::services: true if client and server are not known
};

/// All problems of the cell, sorted by line, each with `file:line` and a fix; empty if there are none.
/// Without file and line, `where` is "cell NAME".
Problems validate(const Cell& cell);
Problems validate(const Cell& cell, const Gaps& gaps);
/// Like the function above, but adds the problems to `findings`. Suppresses problems that only follow from
/// `gaps`.
void validate(const Cell& cell, const Gaps& gaps, Findings& findings);

/// The name of a module that has no <name>: "build/controller1.so" is "controller1".
std::string file_stem(std::string_view filename);

}  // namespace takt::model
