// A program's network settings, from its command-line options and environment variables.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct Network {
  std::optional<int> domain;
  std::string peers;       ///< "10.0.0.1,10.0.0.2"
  std::string server;      ///< "10.0.0.1:11811"
  std::string security{};  ///< a folder; if empty, the value of TAKT_SECURITY is used
};

/// Returns the DDS domain: the value of --domain if given, else of TAKT_DOMAIN, else the cell's domain, else
/// 0. Fails if TAKT_DOMAIN is used and not a valid domain.
Result<int> domain_of(const Network& network, const model::Cell* cell = nullptr);
/// Returns the discovery settings: those of --peers or --server if given, else those of the cell.
model::Discovery discovery_of(const Network& network, const model::Cell* cell = nullptr);
/// Returns the value of --security if given, else of TAKT_SECURITY: an identity folder, or a folder that
/// `takt secure init` created. If empty, DDS Security is off.
std::string security_of(const Network& network);
/// Returns the IPv4 addresses of the network interfaces to use, from TAKT_INTERFACE; empty for all
/// interfaces.
std::vector<std::string> interfaces();

}  // namespace takt::client
