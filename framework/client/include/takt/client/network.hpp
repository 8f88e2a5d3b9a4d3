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
  std::string security{};  ///< a folder; empty for the value of TAKT_SECURITY
};

/// Returns the value of --domain, else TAKT_DOMAIN, else the cell's domain, else 0. Fails if TAKT_DOMAIN is
/// not a valid domain.
Result<int> domain_of(const Network& network, const model::Cell* cell = nullptr);
/// Returns the discovery that --peers or --server sets, else the cell's.
model::Discovery discovery_of(const Network& network, const model::Cell* cell = nullptr);
/// Returns the value of --security, else TAKT_SECURITY. This is the folder of an identity, or a folder that
/// `takt secure init` made. Empty for no DDS Security.
std::string security_of(const Network& network);
/// Returns the IPv4 addresses in TAKT_INTERFACE, which are those of the interfaces to use; empty for all
/// interfaces.
std::vector<std::string> interfaces();

}  // namespace takt::client
