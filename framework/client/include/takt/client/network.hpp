// A program's network settings, from its options and environment.
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
  std::string security{};  ///< a folder; empty: the value of TAKT_SECURITY
};

/// --domain, else TAKT_DOMAIN, else the cell's domain, else 0. Fails if TAKT_DOMAIN is not a valid domain.
Result<int> domain_of(const Network& network, const model::Cell* cell = nullptr);
/// --peers or --server, else the cell's discovery.
model::Discovery discovery_of(const Network& network, const model::Cell* cell = nullptr);
/// --security, else TAKT_SECURITY: the folder of this participant, or one that takt secure init made. Empty:
/// no DDS Security.
std::string security_of(const Network& network);
/// TAKT_INTERFACE: the IPv4 addresses of the interfaces to use; empty: all interfaces.
std::vector<std::string> interfaces();

}  // namespace takt::client
