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
inline constexpr int kMaxTolerance = 1000;  ///< of a budget: times, and in a row
inline constexpr int kMaxCatchUp = 1000;    ///< releases that are made up
inline constexpr int kMaxSpinPercent = 90;  ///< of the basic period
inline constexpr Nanoseconds kMaxBackoff = std::chrono::hours{1};
inline constexpr int kMaxDepth = 65536;
inline constexpr std::size_t kMaxConnections = 100000;              ///< of one cell
inline constexpr std::size_t kMaxServiceName = kMaxNameLength - 8;  ///< with /request it is a port's
inline constexpr std::size_t kMaxTopic = 255;                       ///< bytes; Fast DDS cuts longer names off
inline constexpr std::size_t kMaxPeers = 256;
inline constexpr std::size_t kMaxHost = 253;  ///< bytes

class Findings;

/// A name of a cell, device, executor, module, port or property: a letter or '_', then letters, digits, '_'
/// and '-', at most kMaxNameLength bytes. No dot: `device.module.port` must have one reading.
bool is_valid_name(std::string_view name);

/// A name that a topic of a connection may have: 1 to kMaxTopic printable ASCII characters, no space.
bool is_valid_topic(std::string_view topic);

/// An IPv4 address or a host name, without a port.
bool is_valid_host(std::string_view host);

/// HOST:PORT with a port of 1 to 65535.
bool is_valid_server(std::string_view server);

/// What a reader of a descriptor did not understand, so that nothing is said that only follows from that: a
/// module that could not be read is not a module that a connection names in vain.
struct Gaps {
  struct OfDevice {
    bool executors = false;  ///< there may be executors that the cell does not hold
    bool modules = false;
  };
  bool devices = false;
  bool discovery = false;             ///< how the nodes find each other
  std::vector<OfDevice> of_device;    ///< as Cell::devices; one that is missing has no gaps
  std::vector<bool> without_ends;     ///< as Cell::connections: true where `from` and `to` are not known
  std::vector<bool> without_sides{};  ///< as Cell::services: true where client and server are not known
};

/// All problems of the cell at once, by line, each with `file:line` and a fix; empty when there are none.
/// Where there is neither file nor line, `where` is "cell NAME".
Problems validate(const Cell& cell);
Problems validate(const Cell& cell, const Gaps& gaps);
/// The same, into findings of the cell.
void validate(const Cell& cell, const Gaps& gaps, Findings& findings);

/// The name of a module that has no <name>: "build/controller1.so" is "controller1".
std::string file_stem(std::string_view filename);

}  // namespace takt::model
